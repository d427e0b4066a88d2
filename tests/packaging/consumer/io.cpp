#define BILLOW_IO_IMPLEMENTATION
#include <billow/io.hpp>

int main() { return billow::read_mesh("missing.glb").has_value() ? 1 : 0; }
