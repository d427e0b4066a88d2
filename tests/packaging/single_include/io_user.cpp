#include "billow_io.hpp"

int main() { return 0; }
