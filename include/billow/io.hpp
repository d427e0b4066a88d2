// All of io/. In exactly one .cpp of your program, and before any other header of billow or of the
// libraries below, say
//
//     #define BILLOW_IO_IMPLEMENTATION
//     #include <billow/io.hpp>
//
// which adds the bodies of tinygltf, tinyobjloader, stb_image and stb_image_write. A program that
// has these bodies already leaves it out.
#pragma once

#if defined(BILLOW_IO_IMPLEMENTATION)
#define STBI_FAILURE_USERMSG
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STB_IMAGE_IMPLEMENTATION
#include <stb_image.h>
#undef STB_IMAGE_IMPLEMENTATION

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#undef STB_IMAGE_WRITE_IMPLEMENTATION

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>
#undef TINYOBJLOADER_IMPLEMENTATION

// tinygltf would include it with hidden visibility.
#include <nlohmann/json.hpp>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
#undef TINYGLTF_IMPLEMENTATION
#endif

#include <billow/io/dds.hpp>
#include <billow/io/file.hpp>
#include <billow/io/glb.hpp>
#include <billow/io/gltf.hpp>
#include <billow/io/image_file.hpp>
#include <billow/io/loaded_mesh.hpp>
#include <billow/io/mesh_file.hpp>
#include <billow/io/mip_files.hpp>
#include <billow/io/obj.hpp>
