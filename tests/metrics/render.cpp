#include <billow/metrics/render.hpp>

#include <doctest/doctest.h>

#include <billow/metrics/view_directions.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

const bounding_sphere unit_sphere{dvec3(0), 1};

double covered(const view_picture& picture) {
    double sum = 0;
    for (const vec4& pixel : picture.pixels) sum += static_cast<double>(pixel.w);
    return sum;
}

/// A square of two faces with texture coordinates, v running down along -v.
void add_card(mesh& m, const vec3& centre, const vec3& u, const vec3& v) {
    support::add_square(m, centre, u, v);
    for (const vec2& uv : {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)}) {
        m.uv_sets[0].push_back(uv);
    }
}

/// An image of columns and rows of RGBA.
template <class Pixel>
image picture_of(int width, int height, const Pixel& pixel) {
    image result = image::filled(width, height, 4, 255);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) pixel(x, y, result.pixel(x, y));
    }
    return result;
}

/// The material of all faces shows `shown`.
void give_texture(mesh& m, image shown, alpha_mode alpha, bool is_nearest = false) {
    m.images = {std::move(shown)};
    m.materials.resize(1);
    m.materials[0].base_color_texture.image = 0;
    m.materials[0].base_color_texture.is_nearest = is_nearest;
    m.materials[0].alpha = alpha;
}

view_render rendered(const mesh& m, const camera& from, const render_options& options) {
    render_scratch scratch;
    view_render result;
    scratch.render(render_scene(m), from, options, result);
    return result;
}
view_picture drawn(const mesh& m, const camera& from, const render_options& options = {}) {
    return rendered(m, from, options).picture;
}

bool same(const view_render& a, const view_render& b) {
    return a.picture == b.picture && a.faces == b.faces && a.distances == b.distances &&
           a.counts.covered == b.counts.covered && a.counts.opaque == b.counts.opaque &&
           a.counts.transparent == b.counts.transparent;
}

}  // namespace

TEST_SUITE("metrics/render") {
    TEST_CASE("a square covers the pixels that its solid angle asks for") {
        mesh m;
        support::add_square(m, {0, 0, 0.5f}, {0.4f, 0.1f, 0}, {-0.1f, 0.4f, 0});
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, 100);
        const double side = std::sqrt(0.17) * 2 / 3.5 / from.height * 100;
        for (const int s : {1, 2, 3, 4, 8}) {
            const double area = covered(drawn(m, from, {.supersample = s}));
            CHECK(area == doctest::Approx(side * side).epsilon(s == 1 ? 0.02 : 0.005));
        }
        CHECK(covered(drawn(m, view_of(unit_sphere, {0, 0, 1}, 100, 100))) ==
              doctest::Approx(0.17 * 4 * (100 / 2.04) * (100 / 2.04)).epsilon(0.005));
    }

    TEST_CASE("needles count by their area") {
        random_stream random(4);
        mesh m;
        double area = 0;
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, 128);
        const double pixel = from.height * 4 / 128;  // at the plane z = 0
        for (int i = 0; i < 400; ++i) {
            const double turn = random.between(0, 6.283);
            const dvec3 along(std::cos(turn), std::sin(turn), 0);
            const dvec3 across(-along.y, along.x, 0);
            const dvec3 at = dvec3(random.between(-0.6, 0.6), random.between(-0.6, 0.6), 0);
            for (const dvec3& p : {at, at + along * (8 * pixel), at + across * (0.3 * pixel)}) {
                m.triangles.resize((m.positions.size() + 3) / 3);
                m.positions.emplace_back(p);
            }
            const auto first = static_cast<std::uint32_t>(3 * i);
            m.triangles.back() = {first, first + 1, first + 2};
            area += 0.5 * 8 * 0.3;
        }
        const view_render seen = rendered(m, from, {.counts_fragments = true});
        CHECK(seen.counts.opaque == doctest::Approx(area).epsilon(0.03));
        CHECK(seen.counts.covered <= seen.counts.opaque);
        CHECK(seen.counts.covered == doctest::Approx(covered(seen.picture)));
    }

    TEST_CASE("a card is there where its alpha is, in whole or in part") {
        mesh m;
        add_card(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, 100);
        const double whole = covered(drawn(m, from));
        const auto left_half = [](int x, int, std::uint8_t* p) { p[3] = x < 32 ? 255 : 0; };
        give_texture(m, picture_of(64, 64, left_half), alpha_mode::mask);
        const view_picture masked = drawn(m, from);
        CHECK(covered(masked) == doctest::Approx(0.5 * whole).epsilon(0.02));
        CHECK(masked.at(35, 50).w == 1);
        CHECK(masked.at(65, 50).w == 0);
        m.materials[0].alpha = alpha_mode::opaque;
        CHECK(covered(drawn(m, from)) == whole);
        give_texture(m, picture_of(64, 64, [](int, int, std::uint8_t* p) { p[3] = 64; }),
                     alpha_mode::blend);
        const view_picture blended = drawn(m, from);
        CHECK(blended.at(50, 50).w == doctest::Approx(0.25));
        CHECK(covered(blended) == doctest::Approx(0.25 * whole).epsilon(0.02));
    }

    TEST_CASE("holes smaller than a pixel count by their area, at any distance") {
        mesh m;
        add_card(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        const auto stripes = [](int x, int, std::uint8_t* p) { p[3] = x % 4 == 0 ? 255 : 0; };
        give_texture(m, picture_of(256, 256, stripes), alpha_mode::mask);
        for (const int size : {30, 80, 300}) {
            const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, size);
            const double side = 1 / (4 * from.height) * size;
            CHECK(covered(drawn(m, from)) == doctest::Approx(0.25 * side * side).epsilon(0.1));
        }
    }

    TEST_CASE("textures are where they belong, and are averaged from afar") {
        mesh m;
        add_card(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        const auto quarter = [](int x, int y, std::uint8_t* p) {
            p[0] = p[1] = p[2] = x < 32 && y < 32 ? 255 : 0;
        };
        give_texture(m, picture_of(64, 64, quarter), alpha_mode::opaque);
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, 100);
        const view_picture seen = drawn(m, from);
        CHECK(seen.at(40, 40).x > 0.5f);
        for (const auto& [x, y] : {std::pair(60, 40), std::pair(40, 60), std::pair(60, 60)}) {
            CHECK(seen.at(x, y).x < 0.01f);
            CHECK(seen.at(x, y).w == 1);
        }
        const auto checker = [](int x, int y, std::uint8_t* p) {
            p[0] = p[1] = p[2] = (x + y) % 2 == 0 ? 255 : 0;
        };
        give_texture(m, picture_of(512, 512, checker), alpha_mode::opaque);
        const view_picture grey = drawn(m, from, {.headlight = 1, .sky = 0});
        for (int x = 35; x < 65; ++x) CHECK(grey.at(x, 47).x == doctest::Approx(0.5).epsilon(0.02));
    }

    TEST_CASE("textures lie in perspective, in colour and in alpha") {
        // A floor from z = -1 to -9: its middle is seen at 1/5, not half way from 1/1 to 1/9.
        mesh m;
        add_card(m, {0, -1, -5}, {4, 0, 0}, {0, 0, -4});
        const auto far_half = [](int, int y, std::uint8_t* p) {
            p[0] = p[1] = p[2] = y < 1 ? 255 : 0;
            p[3] = p[0];
        };
        const camera from = perspective_camera({0, 0, 0}, {0, 0, -1}, 1.5707963, 200, 200);
        const auto row_of = [](double slope) { return static_cast<int>(100 + 100 * slope); };
        give_texture(m, picture_of(2, 2, far_half), alpha_mode::opaque, true);
        const view_picture seen = drawn(m, from);
        CHECK(seen.at(100, row_of(0.2) - 2).x > 0.05f);
        CHECK(seen.at(100, row_of(0.2) + 2).x < 0.001f);
        CHECK(seen.at(100, row_of(0.2) + 2).w == 1);
        give_texture(m, picture_of(2, 2, far_half), alpha_mode::mask, true);
        const view_picture holed = drawn(m, from);
        CHECK(holed.at(100, row_of(0.2) - 2).w == 1);
        CHECK(holed.at(100, row_of(0.2) + 2).w == 0);
        CHECK(holed.at(100, row_of(1.0 / 9) - 2).w == 0);
    }

    TEST_CASE("one face takes coarse levels far away and fine ones nearby") {
        mesh m;
        add_card(m, {0, -1, -50}, {50, 0, 0}, {0, 0, -50});
        const auto stripes = [](int x, int, std::uint8_t* p) {
            p[0] = p[1] = p[2] = x / 4 % 2 == 0 ? 255 : 0;
        };
        give_texture(m, picture_of(512, 512, stripes), alpha_mode::opaque);
        m.materials[0].emissive = vec3(1);
        m.materials[0].emissive_texture = m.materials[0].base_color_texture;
        const camera from = perspective_camera({0, 0, 0}, {0, 0, -1}, 1.5707963, 128, 128);
        const view_picture seen = drawn(m, from, {.headlight = 0, .sky = 0});
        const auto range_of = [&](int y) {
            float low = 1;
            float high = 0;
            for (int x = 40; x < 88; ++x) {
                low = std::min(low, seen.at(x, y).x);
                high = std::max(high, seen.at(x, y).x);
            }
            return high - low;
        };
        CHECK(range_of(120) > 0.9f);
        CHECK(range_of(66) < 0.2f);
    }

    TEST_CASE("a camera within a box sees its walls and no gap") {
        const mesh room = box(vec3(2), 3);
        for (const dvec3& at : spread_directions(12)) {
            const camera from =
                perspective_camera(at * 0.6, at * 0.2 + dvec3(0, 0, 0.3), 1.8, 48, 48);
            const view_picture seen = drawn(room, from, {.supersample = 2});
            CHECK(covered(seen) == 48 * 48);
        }
    }

    TEST_CASE("a floor that reaches behind the eye ends at its far edge") {
        mesh floor;
        support::add_square(floor, {0, -1, 0}, {2000, 0, 0}, {0, 0, -10});
        const camera from = perspective_camera({0, 0, 0}, {0, 0, -1}, 1.5707963, 100, 100);
        const view_picture seen = drawn(floor, from);
        // The far edge is seen at a slope of 1/10: 5 pixels below the middle.
        for (const int x : {1, 50, 98}) {
            CHECK(seen.at(x, 54).w == 0);
            CHECK(seen.at(x, 55).w == 1);
            CHECK(seen.at(x, 99).w == 1);
        }
    }

    TEST_CASE("faces look the same from both sides") {
        mesh m;
        support::add_square(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        const auto from = [](double z) { return orbit_camera(unit_sphere, {0, 0, z}, 4, 32); };
        const view_picture front = drawn(m, from(1));
        const view_picture back = drawn(m, from(-1));
        for (std::size_t i = 0; i < front.pixels.size(); ++i) {
            CHECK(glm::length(front.pixels[i] - back.pixels[i]) < 1e-5f);
        }
        CHECK(front.at(16, 16).x == doctest::Approx(0.7 + 0.35 * 0.75).epsilon(0.01));
    }

    TEST_CASE("normal textures turn the light") {
        mesh m;
        add_card(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        give_texture(m, picture_of(4, 4, [](int, int, std::uint8_t*) {}), alpha_mode::opaque);
        const auto tilted = [](int, int, std::uint8_t* p) {
            p[0] = 128 + 76, p[1] = 128, p[2] = 128 + 102;  // (0.6, 0, 0.8)
        };
        m.images.push_back(picture_of(4, 4, tilted));
        m.materials[0].normal_texture.image = 1;
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 40, 32);
        const view_picture seen = drawn(m, from, {.headlight = 1, .sky = 0});
        CHECK(seen.at(16, 16).x == doctest::Approx(0.8).epsilon(0.01));
    }

    TEST_CASE("from far away perspective is orthographic") {
        const mesh m = leaf_soup(300);
        const view_render flat = rendered(m, view_of(unit_sphere, {1, 2, 3}, 64, 64), {});
        const view_render far = rendered(m, orbit_camera(unit_sphere, {1, 2, 3}, 2000, 64), {});
        double different = 0;
        for (std::size_t i = 0; i < flat.picture.pixels.size(); ++i) {
            different += glm::length(flat.picture.pixels[i] - far.picture.pixels[i]) > 0.1f;
        }
        CHECK(flat.counts.covered > 150);
        CHECK(different < 0.01 * flat.counts.covered);
    }

    TEST_CASE("fragments are counted, hidden or not") {
        mesh m;
        add_card(m, {0, 0, 0.001f}, {0.5f, 0, 0}, {0, 0.5f, 0});
        add_card(m, vec3(0), {0.5f, 0, 0}, {0, 0.5f, 0});
        const auto half = [](int, int y, std::uint8_t* p) { p[3] = y < 16 ? 255 : 0; };
        give_texture(m, picture_of(32, 32, half), alpha_mode::mask);
        m.materials.resize(2);
        m.face_materials = {0, 0, 1, 1};
        const camera from = view_of(unit_sphere, {0, 0, 1}, 102, 102);  // the cards have 50² pixels
        const render_counts counts = rendered(m, from, {.counts_fragments = true}).counts;
        CHECK(counts.covered == doctest::Approx(2500).epsilon(0.01));
        CHECK(counts.opaque == doctest::Approx(3750).epsilon(0.01));
        CHECK(counts.transparent == doctest::Approx(1250).epsilon(0.02));
        CHECK(counts.overdraw() == doctest::Approx(2).epsilon(0.01));
        CHECK(rendered(m, from, {}).counts.covered == counts.covered);
        CHECK(rendered(m, from, {}).counts.opaque == 0);
    }

    TEST_CASE("faces and distances of pixel centres are given on request") {
        mesh m;
        support::add_square(m, {0, 0, -2}, {1, 0, 0}, {0, 1, 0});
        const camera from = perspective_camera({0, 0, 3}, {0, 0, 0}, 1, 31, 31);
        const render_options wanted{.keeps_faces = true, .keeps_distances = true};
        const view_render seen = rendered(m, from, wanted);
        REQUIRE(seen.faces.size() == 31 * 31);
        REQUIRE(seen.distances.size() == 31 * 31);
        CHECK(seen.faces[0] == no_id);
        CHECK(std::isinf(seen.distances[0]));
        CHECK(seen.faces[14 * 31 + 16] < 2);
        CHECK(seen.distances[14 * 31 + 16] == doctest::Approx(5));
        CHECK(rendered(m, from, {}).faces.empty());
        const camera flat = view_of({dvec3(0, 0, 3), 2}, {0, 0, 1}, 31, 31);
        CHECK(rendered(m, flat, wanted).distances[15 * 31 + 15] == doctest::Approx(5));
    }

    TEST_CASE("threads and views before do not change what is seen") {
        const mesh leaves = leaf_soup(2000);
        mesh cards = support::random_triangles(50, 0.5, 3);
        cards.materials.resize(1);
        cards.materials[0].alpha = alpha_mode::blend;
        cards.materials[0].base_color.w = 0.4f;
        const render_scene a(leaves);
        const render_scene b(cards);
        const std::array<const render_scene*, 2> scenes{&a, &b};
        std::vector<camera> cameras;
        for (const dvec3& d : spread_directions(7)) {
            cameras.push_back(orbit_camera(a.bounds, d, 4, 90));
        }
        const render_options options{.supersample = 3,
                                     .keeps_faces = true,
                                     .keeps_distances = true,
                                     .counts_fragments = true};
        std::vector<std::array<view_render, 2>> expected(cameras.size());
        for (std::size_t i = 0; i < cameras.size(); ++i) {
            for (std::size_t k = 0; k < 2; ++k) {
                render_scratch scratch;
                scratch.render(*scenes[k], cameras[i], options, expected[i][k], {k == 0 ? 1u : 3u});
            }
            CHECK(render_view(a, cameras[i], options, {2}) == expected[i][0].picture);
        }
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            std::vector<int> is_same(cameras.size(), 0);
            for_views(scenes, cameras, options, {threads}, [&](std::size_t i, const auto& renders) {
                is_same[i] = same(renders[0], expected[i][0]) && same(renders[1], expected[i][1]);
            });
            for (const int yes : is_same) CHECK(yes == 1);
        }
    }

    TEST_CASE("a scene that culls backs shows single-sided faces from their front alone") {
        mesh m;
        add_card(m, {0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
        const auto seen_from = [&](const dvec3& direction, bool is_culled) {
            render_scratch scratch;
            view_render result;
            scratch.render(render_scene(m, is_culled), orbit_camera(unit_sphere, direction, 4, 20),
                           {.counts_fragments = true}, result);
            return result.counts;
        };
        const double front = seen_from({0, 0, 1}, false).covered;
        CHECK(front > 10);
        CHECK(seen_from({0, 0, 1}, true).covered == front);
        CHECK(seen_from({0, 0, -1}, false).covered == doctest::Approx(front));
        CHECK(seen_from({0, 0, -1}, true).covered == 0);
        CHECK(seen_from({0, 0, -1}, true).opaque == 0);
        m.materials.resize(1);
        m.materials[0].is_double_sided = true;
        CHECK(seen_from({0, 0, -1}, true).covered == seen_from({0, 0, -1}, false).covered);
        // A face that the near plane cuts is culled as a whole one is.
        m.materials[0].is_double_sided = false;
        const camera close = perspective_camera({0, 0, 0.1}, {0.4, 0, 0}, 1, 20, 20, 0.15);
        const camera behind = perspective_camera({0, 0, -0.1}, {0.4, 0, 0}, 1, 20, 20, 0.15);
        CHECK(covered(render_view(render_scene(m, true), close)) ==
              covered(render_view(render_scene(m), close)));
        CHECK(covered(render_view(render_scene(m), behind)) > 0);
        CHECK(covered(render_view(render_scene(m, true), behind)) == 0);
    }

    TEST_CASE("nothing is drawn of nothing, of faces without area and on no pixels") {
        const camera from = orbit_camera(unit_sphere, {0, 0, 1}, 4, 20);
        CHECK(covered(drawn(mesh{}, from)) == 0);
        mesh m =
            support::triangles({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 1, 0}, {2, 2, 0}});
        CHECK(covered(drawn(m, from)) == 0);
        CHECK(covered(drawn(m, perspective_camera({0, 0, 0}, {0, 0, -1}, 1, 20, 20))) == 0);
        camera none = from;
        none.width_px = none.height_px = 0;
        CHECK(drawn(m, none).pixels.empty());
    }
}
