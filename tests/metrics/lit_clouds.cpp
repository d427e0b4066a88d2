// Whether clouds are lit as their originals are, by the renderer that clouds are measured with.
#include <billow/metrics/render.hpp>

#include <doctest/doctest.h>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/metrics/camera.hpp>

namespace {

using namespace billow;

/// A card whose normals lean outwards, as those of a leaf do.
mesh bent_card() {
    mesh m;
    for (const vec2& p : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
        m.positions.emplace_back(p.x * 0.5f, p.y * 0.5f, 0);
        m.normals.push_back(glm::normalize(vec3(p.x * 0.6f, p.y * 0.4f, 1)));
    }
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    m.materials = {
        {.base_color = vec4(0.6f, 0.7f, 0.3f, 1), .metallic = 0, .is_double_sided = true}};
    return m;
}

mesh cloud_of(const mesh& m, normal_style normals, tile_sides sides) {
    billboard_cloud cloud;
    cloud.bounds = {dvec3(0), 1};
    cloud.epsilon = 0.1;
    cloud.planes = {{{0, 0, 1}, 0}};
    cloud.plane_of_face = {0, 0};
    fit_billboards(m, cloud);
    bake_options options{.texels = 128, .sides = sides};
    options.draw.normals = normals;
    const auto faces = make_face_table(m);
    REQUIRE(faces);
    const baked_cloud baked = bake_cloud(m, *faces, cloud, options);
    return cloud_mesh(cloud, baked);
}

/// Mean difference of light where both are covered wholly.
double lit_difference(const mesh& a, const mesh& b, const dvec3& from) {
    const camera eye = view_of({dvec3(0), 0.8}, from, 96, 96);
    const render_scene scene_a(a, true);
    const render_scene scene_b(b, true);
    const view_picture of_a = render_view(scene_a, eye);
    const view_picture of_b = render_view(scene_b, eye);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < of_a.pixels.size(); ++i) {
        if (of_a.pixels[i].a < 0.999f || of_b.pixels[i].a < 0.999f) continue;
        const vec3 apart = glm::abs(vec3(of_a.pixels[i]) - vec3(of_b.pixels[i]));
        sum += static_cast<double>(std::max({apart.x, apart.y, apart.z}));
        ++count;
    }
    REQUIRE(count > 800);
    return sum / count;
}

}  // namespace

TEST_SUITE("metrics/lit_clouds") {
    TEST_CASE(
        "sheets, and object normals with two sides, are lit as the mesh is, from all around") {
        const mesh card = bent_card();
        const mesh sheets = cloud_of(card, normal_style::sheets, tile_sides::one);
        const mesh object = cloud_of(card, normal_style::object, tile_sides::two);
        for (const dvec3 from : {dvec3(0, 0, 1), dvec3(0.5, 0.3, 1), dvec3(0, 0, -1),
                                 dvec3(-0.4, 0.5, -1), dvec3(0.7, -0.4, -1)}) {
            CHECK(lit_difference(card, sheets, from) < 0.006);
            CHECK(lit_difference(card, object, from) < 0.006);
        }
    }
    TEST_CASE("folded normals are lit as the mesh is, on a double-sided polygon") {
        const mesh card = bent_card();
        const mesh folded = cloud_of(card, normal_style::folded, tile_sides::one);
        for (const dvec3 from : {dvec3(0, 0, 1), dvec3(0.5, 0.3, 1), dvec3(0, 0, -1)}) {
            CHECK(lit_difference(card, folded, from) < 0.006);
        }
    }
    TEST_CASE("of two colours back to back, each side shows its own") {
        mesh m = bent_card();
        const mesh other = bent_card();
        for (std::size_t i = 0; i < 4; ++i) {
            m.positions.push_back(other.positions[i] - vec3(0, 0, 0.02f));
            m.normals.push_back(-other.normals[i]);
        }
        m.triangles.push_back({4, 6, 5});
        m.triangles.push_back({4, 7, 6});
        m.materials = {{.base_color = vec4(0.8f, 0.1f, 0.1f, 1), .metallic = 0},
                       {.base_color = vec4(0.1f, 0.1f, 0.8f, 1), .metallic = 0}};
        m.face_materials = {0, 0, 1, 1};
        billboard_cloud cloud;
        cloud.bounds = {dvec3(0), 1};
        cloud.epsilon = 0.1;
        cloud.planes = {{{0, 0, 1}, -0.01}};
        cloud.plane_of_face = {0, 0, 0, 0};
        fit_billboards(m, cloud);
        const auto faces = make_face_table(m);
        REQUIRE(faces);
        for (const tile_sides sides : {tile_sides::automatic, tile_sides::one}) {
            billboard_cloud copy = cloud;
            const baked_cloud baked = bake_cloud(m, *faces, copy, {.texels = 96, .sides = sides});
            const mesh cards = cloud_mesh(copy, baked);
            const dvec3 front = copy.billboards[0].axes.normal;
            CHECK(lit_difference(m, cards, front) < 0.01);
            const bool has_back = sides == tile_sides::automatic;
            CHECK((lit_difference(m, cards, -front) < 0.01) == has_back);
        }
    }
}
