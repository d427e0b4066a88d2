#include "billow_io.hpp"

int main() { return billow::read_mesh("missing.glb").has_value() ? 1 : 0; }
