# What billow stands on. CMakeLists.txt reads this file and so does the installed
# billowConfig.cmake, so each package is named once.

# billow_find(<list> TARGET <target> (PACKAGE <package> | HEADER <header>)
#             APT <name> VCPKG <name> [BREW <name>])
#
# Makes <target> available, from the package's own CMake config or from the folder that holds
# <header>. Where neither is found, appends a line that says what to install to <list>.
function(billow_find list_of_missing)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "TARGET;PACKAGE;HEADER;APT;BREW;VCPKG" "")
    if(TARGET ${arg_TARGET})
        return()
    endif()
    if(arg_PACKAGE)
        find_package(${arg_PACKAGE} CONFIG QUIET)
    else()
        string(MAKE_C_IDENTIFIER "BILLOW_${arg_HEADER}_DIR" folder)
        string(TOUPPER ${folder} folder)
        # Debian keeps stb in a folder of its own, vcpkg does not.
        find_path(${folder} ${arg_HEADER} PATH_SUFFIXES stb DOC "Folder of ${arg_HEADER}")
        mark_as_advanced(${folder})
        if(${folder})
            add_library(${arg_TARGET} INTERFACE IMPORTED GLOBAL)
            set_target_properties(
                ${arg_TARGET} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${${folder}}")
        endif()
    endif()
    if(NOT TARGET ${arg_TARGET})
        if(NOT arg_BREW)
            set(arg_BREW none)
        endif()
        list(APPEND ${list_of_missing} "${arg_PACKAGE}${arg_HEADER}\
  (apt: ${arg_APT}, brew: ${arg_BREW}, vcpkg: ${arg_VCPKG})")
        set(${list_of_missing} "${${list_of_missing}}" PARENT_SCOPE)
    endif()
endfunction()

# What billow::billow needs.
macro(billow_find_core missing)
    billow_find(${missing} TARGET glm::glm PACKAGE glm APT libglm-dev BREW glm VCPKG glm)
    billow_find(${missing} TARGET Eigen3::Eigen PACKAGE Eigen3
        APT libeigen3-dev BREW eigen VCPKG eigen3)
endmacro()

# What billow::io needs beyond billow::billow.
macro(billow_find_io missing)
    billow_find(${missing} TARGET nlohmann_json::nlohmann_json PACKAGE nlohmann_json
        APT nlohmann-json3-dev BREW nlohmann-json VCPKG nlohmann-json)
    billow_find(${missing} TARGET billow::stb HEADER stb_image.h APT libstb-dev VCPKG stb)
    billow_find(${missing} TARGET billow::tinygltf HEADER tiny_gltf.h
        APT libtinygltf-dev VCPKG tinygltf)
    billow_find(${missing} TARGET billow::tinyobjloader HEADER tiny_obj_loader.h
        APT libtinyobjloader-dev VCPKG tinyobjloader)
endmacro()

# What billow::io uses where it is there: makes billow::libdeflate, which tells the headers so.
# libdeflate has a CMake config of its own only since 1.15.
macro(billow_find_libdeflate)
    find_path(BILLOW_LIBDEFLATE_H_DIR libdeflate.h DOC "Folder of libdeflate.h")
    find_library(BILLOW_LIBDEFLATE_LIBRARY
        NAMES deflate libdeflate deflatestatic libdeflatestatic DOC "libdeflate")
    mark_as_advanced(BILLOW_LIBDEFLATE_H_DIR BILLOW_LIBDEFLATE_LIBRARY)
    if(BILLOW_LIBDEFLATE_H_DIR AND BILLOW_LIBDEFLATE_LIBRARY AND NOT TARGET billow::libdeflate)
        add_library(billow::libdeflate INTERFACE IMPORTED GLOBAL)
        set_target_properties(billow::libdeflate PROPERTIES
            INTERFACE_INCLUDE_DIRECTORIES "${BILLOW_LIBDEFLATE_H_DIR}"
            INTERFACE_LINK_LIBRARIES "${BILLOW_LIBDEFLATE_LIBRARY}"
            INTERFACE_COMPILE_DEFINITIONS BILLOW_HAS_LIBDEFLATE)
    endif()
endmacro()

# What billow::reduce needs beyond billow::billow.
macro(billow_find_reduce missing)
    billow_find(${missing} TARGET meshoptimizer::meshoptimizer PACKAGE meshoptimizer
        APT libmeshoptimizer-dev BREW meshoptimizer VCPKG meshoptimizer)
endmacro()
