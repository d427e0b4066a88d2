// Fails unless the tags of the two translation units are as the first argument says.
#include <cstdio>
#include <string_view>

#include "tags.hpp"

int main(int count, char** arguments) {
    std::printf("%s %s\n", tag_of_one(), tag_of_other());
    const bool are_equal = std::string_view(tag_of_one()) == tag_of_other();
    return count == 2 && std::string_view(arguments[1]) == (are_equal ? "equal" : "different") ? 0
                                                                                                 : 1;
}
