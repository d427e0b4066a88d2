// Compiled for another instruction set than one.cpp.
#include "other.cpp"
