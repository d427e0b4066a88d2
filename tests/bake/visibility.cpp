#include <billow/bake/visibility.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

/// The square [0, 1]² in the plane z, as two triangles.
void add_square(mesh& m, float z) {
    const auto first = static_cast<std::uint32_t>(m.positions.size());
    m.positions.insert(m.positions.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    m.uv_sets[0].insert(m.uv_sets[0].end(), {{0, 1}, {1, 1}, {1, 0}, {0, 0}});
    m.triangles.push_back({first, first + 1, first + 2});
    m.triangles.push_back({first, first + 2, first + 3});
}

/// Draws a mesh over a grid of `size` samples a side; gives the share that is covered.
double covered_share(const mesh& m, int size, int supersample = 4) {
    const surface look(m);
    visibility_buffer buffer(supersample);
    buffer.start({0, 0, size, size});
    const orthographic_view view{{}, {0, 1, 0}, 1.0 / size};
    for (face_id f = 0; f < m.face_count(); ++f) buffer.draw(look, view, f, {});
    int covered = 0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) covered += buffer.faces_of_row(y)[x] != no_id;
    }
    return static_cast<double>(covered) / (size * size);
}

/// The samples that a flat mesh covers, whose positions are in samples of a grid 128 a side.
int covered_samples(const mesh& m) {
    constexpr int size = 128;
    const surface look(m);
    visibility_buffer buffer(4);
    buffer.start({0, 0, size, size});
    const orthographic_view view{{}, {0, size, 0}, 1};
    for (face_id f = 0; f < m.face_count(); ++f) buffer.draw(look, view, f, {});
    int covered = 0;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) covered += buffer.faces_of_row(y)[x] != no_id;
    }
    return covered;
}

/// A ribbon of two triangles about a point.
mesh ribbon(const dvec2& centre, double angle, double length, double width) {
    const dvec2 along = dvec2(std::cos(angle), std::sin(angle)) * (0.5 * length);
    const dvec2 across = dvec2(-std::sin(angle), std::cos(angle)) * (0.5 * width);
    mesh m;
    for (const dvec2& p : {-along - across, along - across, along + across, across - along}) {
        m.positions.emplace_back(vec2(centre + p), 0.0f);
    }
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

mesh textured_square(image picture, alpha_mode alpha) {
    mesh m;
    add_square(m, 0);
    m.images = {std::move(picture)};
    m.materials = {{.base_color_texture = {.image = 0}, .alpha = alpha}};
    return m;
}

}  // namespace

TEST_SUITE("bake/visibility") {
    TEST_CASE("the greatest height wins, then the lowest face") {
        mesh m;
        add_square(m, 0);
        add_square(m, 0.5f);
        add_square(m, 0.5f);
        const surface look(m);
        visibility_buffer buffer;
        buffer.start({0, 0, 8, 8});
        const orthographic_view view{{}, {0, 1, 0}, 1.0 / 8};
        for (face_id f = 0; f < 6; ++f) buffer.draw(look, view, f, {});
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 8; ++x) {
                const face_id face = buffer.faces_of_row(y)[x];
                CHECK((face == 2 || face == 3));
            }
        }
        buffer.start({0, 0, 8, 8});
        for (face_id f = 0; f < 6; ++f) buffer.draw(look, view, f, {-0.1, 0.4});
        CHECK(buffer.faces_of_row(3)[6] < 2);
    }

    TEST_CASE("a sloped face is cut where the range ends") {
        mesh m;
        add_square(m, 0);
        m.positions[1].z = m.positions[2].z = 1;  // height = x
        const surface look(m);
        visibility_buffer buffer;
        buffer.start({0, 0, 64, 64});
        for (face_id f = 0; f < 2; ++f) {
            buffer.draw(look, {{}, {0, 1, 0}, 1.0 / 64}, f, {0.25, 0.75});
        }
        for (int x = 0; x < 64; ++x) {
            CHECK((buffer.faces_of_row(20)[x] != no_id) == (x >= 16 && x < 48));
        }
    }

    TEST_CASE("blended alpha covers its share of the samples") {
        for (int alpha = 0; alpha <= 255; alpha += 15) {
            image picture = image::filled(2, 2, 4, static_cast<std::uint8_t>(alpha));
            const double share = covered_share(textured_square(picture, alpha_mode::blend), 64, 4);
            CHECK(std::abs(share - alpha / 255.0) < 0.04);
        }
        mesh m = textured_square(image::filled(1, 1, 4, 255), alpha_mode::blend);
        m.materials[0].base_color.w = 0.5f;
        m.colors.assign(4, vec4(1, 1, 1, 0.5f));
        CHECK(std::abs(covered_share(m, 64) - 0.25) < 0.02);
    }

    TEST_CASE("of two half-transparent faces the lower shows through") {
        mesh m = textured_square(image::filled(1, 1, 4, 128), alpha_mode::blend);
        m.triangles.pop_back();
        m.triangles.push_back({0, 1, 2});
        const double one = covered_share(m, 64);
        m.triangles.pop_back();
        CHECK(one > covered_share(m, 64) * 1.2);
    }

    TEST_CASE("opaque materials ignore alpha, masks compare it with the cutoff") {
        image picture = image::filled(2, 2, 4, 100);
        CHECK(covered_share(textured_square(picture, alpha_mode::opaque), 32) == 1);
        mesh m = textured_square(picture, alpha_mode::mask);
        CHECK(covered_share(m, 32) == 0);
        m.materials[0].alpha_cutoff = 0.39f;
        CHECK(covered_share(m, 32) == 1);
        m.materials[0].base_color.w = 0.9f;
        CHECK(covered_share(m, 32) == 0);
        m.materials[0].base_color.w = 1;
        m.colors.assign(4, vec4(1, 1, 1, 0.9f));
        CHECK(covered_share(m, 32) == 0);
    }

    TEST_CASE("a fine mask seen from afar keeps its covered share") {
        // Bars of one texel in five, as needles are. Mean alpha (0.2) would fail the cutoff
        // everywhere; point samples at level 0 would hit all bars or none at unlucky sizes.
        image bars = image::filled(640, 640, 4, 0);
        for (int y = 0; y < 640; ++y) {
            for (int x = 0; x < 640; x += 5) bars.pixel(x, y)[3] = 255;
        }
        const mesh m = textured_square(bars, alpha_mode::mask);
        for (const int size : {16, 32, 64, 96, 128}) {
            CAPTURE(size);
            CHECK(std::abs(covered_share(m, size) - 0.2) < 0.06);
        }
        CHECK(std::abs(covered_share(m, 640) - 0.2) < 0.06);
    }

    TEST_CASE("packs of samples draw what single samples draw") {
        image picture = image::filled(37, 20, 4, 0);
        for (std::size_t i = 3; i < picture.bytes.size(); i += 4) {
            picture.bytes[i] = static_cast<std::uint8_t>(mix_bits(i) >> 56);
        }
        for (const auto alpha : {alpha_mode::opaque, alpha_mode::mask, alpha_mode::blend}) {
            for (const auto wrap : {texture_wrap::repeat, texture_wrap::clamp_to_edge,
                                    texture_wrap::mirrored_repeat}) {
                for (const bool is_nearest : {false, true}) {
                    random_stream random(static_cast<std::uint64_t>(wrap) + 1);
                    mesh m;
                    for (std::uint32_t f = 0; f < 150; ++f) {
                        const double reach = f % 3 == 0 ? 0.5 : 0.1;
                        const dvec2 at(random.unit(), random.unit());
                        for (int k = 0; k < 3; ++k) {
                            m.positions.emplace_back(at.x + random.between(-reach, reach),
                                                     at.y + random.between(-reach, reach),
                                                     f % 5 == 0 ? 0.5 : random.unit());
                            m.uv_sets[0].emplace_back(random.between(-1.5, 2.5), random.unit());
                            m.colors.emplace_back(1, 1, 1, f % 2 == 0 ? 1 : 0.7);
                        }
                        m.triangles.push_back({3 * f, 3 * f + 1, 3 * f + 2});
                    }
                    m.images = {picture};
                    m.materials = {{.base_color_texture = {.image = 0,
                                                           .wrap_u = wrap,
                                                           .wrap_v = wrap,
                                                           .is_nearest = is_nearest},
                                    .alpha = alpha}};
                    if (is_nearest) m.colors.clear();
                    const surface look(m);
                    const orthographic_view view{{}, {0, 1, 0}, 1.0 / 61};
                    visibility_buffer packs(3);
                    visibility_buffer single(3);
                    packs.start({0, 0, 61, 47});
                    single.start({0, 0, 61, 47});
                    for (face_id f = 0; f < m.face_count(); ++f) {
                        packs.draw(look, view, f, {0.1, 0.9});
                        single.draw<float>(look, view, f, {0.1, 0.9});
                    }
                    bool is_same = true;
                    for (int y = 0; y < 47; ++y) {
                        is_same =
                            is_same && std::equal(packs.faces_of_row(y), packs.faces_of_row(y) + 61,
                                                  single.faces_of_row(y));
                    }
                    CHECK(is_same);
                }
            }
        }
    }

    TEST_CASE("a ribbon a tenth of a texel wide shows its area at any angle") {
        // 0.4 samples of 4 × 4 a texel, 100 long. By the rule alone a ribbon along the grid covers
        // nothing six times in ten; one that the rule favours keeps what it takes.
        random_stream random(3);
        double sum = 0;
        for (int degrees = 0; degrees < 180; ++degrees) {
            for (int round = 0; round < 4; ++round) {
                const double off = round / 4.0;
                const dvec2 centre(64 + random.unit(), 64 + off);
                const double angle = degrees * std::numbers::pi / 180;
                const int covered = covered_samples(ribbon(centre, angle, 100, 0.4));
                CAPTURE(degrees);
                CAPTURE(off);
                CHECK(covered >= 34);
                if (degrees % 90 > 3 && degrees % 90 < 87 && degrees % 45 != 0)
                    CHECK(covered <= 50);
                sum += covered;
            }
        }
        CHECK(std::abs(sum / 720 - 40) < 2);  // 3 % more than its area on average
    }

    TEST_CASE("slivers side by side cover what their outline does") {
        random_stream random(5);
        for (int round = 0; round < 20; ++round) {
            mesh m;  // a strip of triangles 0.5 samples wide and 90 long: a quad of 40 × 90
            const dvec2 corner(20 + random.unit(), 20 + random.unit());
            const double turn = random.between(-0.2, 0.2);
            for (int i = 0; i <= 80; ++i) {
                for (const double y : {0.0, 90.0}) {
                    const double x = 0.5 * i;
                    m.positions.emplace_back(corner.x + x - turn * y, corner.y + y + turn * x, 0);
                }
            }
            for (std::uint32_t i = 0; i < 160; ++i) m.triangles.push_back({i, i + 1, i + 2});
            const double area = 40 * 90 * (1 + turn * turn);
            CHECK(std::abs(covered_samples(m) / area - 1) < 0.01);
        }
    }

    TEST_CASE("a sliver looks up its alpha within itself") {
        // The texture is opaque but for what lies beyond the corners.
        image picture = image::filled(64, 64, 4, 0);
        for (int y = 24; y < 40; ++y) {
            for (int x = 0; x < 64; ++x) picture.pixel(x, y)[3] = 255;
        }
        mesh m = ribbon({64, 64.0}, 0, 100, 0.4);
        m.uv_sets[0] = {{0, 0.4f}, {1, 0.4f}, {1, 0.6f}, {0, 0.6f}};
        m.images = {picture};
        m.materials = {
            {.base_color_texture = {.image = 0, .is_nearest = true}, .alpha = alpha_mode::mask}};
        CHECK(covered_samples(m) >= 34);
    }

    TEST_CASE("a point beside a face is shaded as the nearest point of the face") {
        mesh m;
        m.positions = {{0, 0, 0}, {10, 0, 0}, {10, 0.1f, 0}};
        m.colors = {{0, 0, 0, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}};
        m.triangles = {{0, 1, 2}};
        const surface look(m);
        view_shader shader(look, 4);
        shader.start({{}, {0, 4, 0}, 1});
        for (const double y : {2.0, 3.9, 4.0, 4.4, 7.0}) {
            CHECK(shader.at(0, {4, y}).base_color.x == doctest::Approx(0.4).epsilon(0.02));
        }
        CHECK(shader.at(0, {-3, 4}).base_color.x == 0);
        CHECK(shader.at(0, {14, 4}).base_color.x == doctest::Approx(1));
    }

    TEST_CASE("bayer thresholds are spread evenly") {
        for (int side = 1; side <= max_supersample; ++side) {
            const detail::dither_matrix dither(side);
            std::vector<float> values;
            for (int y = 0; y < side; ++y) {
                for (int x = 0; x < side; ++x) values.push_back(dither.threshold(x, y, 7));
            }
            std::sort(values.begin(), values.end());
            for (std::size_t i = 0; i < values.size(); ++i) {
                CHECK(values[i] == doctest::Approx((static_cast<double>(i) + 0.5) /
                                                   static_cast<double>(values.size())));
            }
        }
    }

    TEST_CASE("the samples of a texel are grouped by face") {
        mesh m;
        add_square(m, 0);
        const surface look(m);
        visibility_buffer buffer(4);
        buffer.start({0, 0, 4, 4});
        for (face_id f = 0; f < 2; ++f) buffer.draw(look, {{}, {0, 1, 0}, 0.25}, f, {});
        std::array<texel_part, max_supersample * max_supersample> parts;
        REQUIRE(parts_of_texel(buffer, 0, 0, 4, parts) == 2);
        CHECK(parts[0].samples + parts[1].samples == 16);
        const dvec2 centre = parts[0].centre * (parts[0].samples / 16.0) +
                             parts[1].centre * (parts[1].samples / 16.0);
        CHECK(glm::distance(centre, dvec2(2, 2)) < 1e-12);
    }
}
