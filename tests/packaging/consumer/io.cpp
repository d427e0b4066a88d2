#define BILLOW_IO_IMPLEMENTATION
#include <billow/billow.hpp>
#include <billow/io.hpp>

int main() { return 0; }
