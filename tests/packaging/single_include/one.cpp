#include "billow.hpp"
#include "tags.hpp"

const char* tag_of_one() { return BILLOW_ABI_NAME; }
