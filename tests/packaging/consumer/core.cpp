// Fails unless the headers found are of the version that the first argument names.
#include <cstdio>
#include <cstring>

#include <billow/billow.hpp>

int main(int count, char** arguments) {
    billow::mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    std::printf("billow %s, %s\n", BILLOW_VERSION, BILLOW_ABI_NAME);
    return count == 2 && std::strcmp(arguments[1], BILLOW_VERSION) == 0 && mesh.face_count() == 1
               ? 0
               : 1;
}
