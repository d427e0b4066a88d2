// The one place of the test executable that holds the third parties' bodies.
#define BILLOW_IO_IMPLEMENTATION
#include <billow/io.hpp>
