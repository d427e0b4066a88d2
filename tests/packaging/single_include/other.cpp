#include "billow.hpp"
#include "tags.hpp"

const char* tag_of_other() { return BILLOW_ABI_NAME; }
