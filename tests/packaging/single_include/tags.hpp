// What the two translation units tell each other.
#pragma once

const char* tag_of_one();
const char* tag_of_other();
