// The version of the library. CMakeLists.txt reads it from here, so it is written once.
#pragma once

#define BILLOW_VERSION_MAJOR 0
#define BILLOW_VERSION_MINOR 1
#define BILLOW_VERSION_PATCH 0
#define BILLOW_VERSION "0.1.0"
