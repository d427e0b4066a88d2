#include <billow/reduce.hpp>
#include <billow/shapes/sphere.hpp>

int main() {
    const billow::mesh ball = billow::icosphere(3);
    return billow::reduce_mesh(ball, 0.5).mesh.face_count() < ball.face_count() ? 0 : 1;
}
