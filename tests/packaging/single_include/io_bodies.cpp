#define BILLOW_IO_IMPLEMENTATION
#include "billow_io.hpp"
