#include <billow/bake/bake_cloud.hpp>

#include <doctest/doctest.h>

#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/metrics/picture.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

namespace {

using namespace billow;

struct baked_scene {
    billboard_cloud cloud;
    baked_cloud baked;
};

/// A cloud of the given planes (relative to the origin); every face goes to the nearest one.
billboard_cloud cloud_on(const mesh& m, const std::vector<plane>& planes, double epsilon,
                         double radius) {
    billboard_cloud cloud;
    cloud.bounds = {dvec3(0), radius};
    cloud.epsilon = epsilon;
    cloud.planes = planes;
    for (face_id face = 0; face < m.face_count(); ++face) {
        plane_id best = 0;
        double least = 1e300;
        for (plane_id id = 0; id < planes.size(); ++id) {
            double farthest = 0;
            for (const vec3& c : m.corners(face)) {
                farthest = std::max(farthest, std::abs(signed_distance(planes[id], dvec3(c))));
            }
            if (farthest < least) {
                least = farthest;
                best = id;
            }
        }
        cloud.plane_of_face.push_back(best);
    }
    fit_billboards(m, cloud);
    return cloud;
}

baked_scene bake(const mesh& m, billboard_cloud cloud, const bake_options& options,
                 parallel threads = {}) {
    baked_scene s{std::move(cloud), {}};
    const auto faces = make_face_table(m);
    REQUIRE(faces);
    s.baked = bake_cloud(m, *faces, s.cloud, options, threads);
    return s;
}

std::vector<plane> box_planes() {
    return {{{1, 0, 0}, .5},  {{-1, 0, 0}, .5}, {{0, 1, 0}, .5},
            {{0, -1, 0}, .5}, {{0, 0, 1}, .5},  {{0, 0, -1}, .5}};
}

std::vector<plane> three_walls() { return {{{1, 0, 0}, 0}, {{0, 1, 0}, 0}, {{0, 0, 1}, 0}}; }

/// A quad of the given size in the plane z = 0, centred, uv upright.
mesh quad(float width, float height) {
    mesh m;
    m.positions = {{-width / 2, -height / 2, 0},
                   {width / 2, -height / 2, 0},
                   {width / 2, height / 2, 0},
                   {-width / 2, height / 2, 0}};
    m.uv_sets[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    m.materials = {{.metallic = 0, .is_double_sided = true}};
    return m;
}

void give_texture(mesh& m, image picture, alpha_mode alpha = alpha_mode::opaque) {
    m.images = {std::move(picture)};
    m.materials[0].base_color_texture = {
        .image = 0, .wrap_u = texture_wrap::clamp_to_edge, .wrap_v = texture_wrap::clamp_to_edge};
    m.materials[0].alpha = alpha;
}

const std::uint8_t* texel_of(const baked_scene& s, const image atlas::*channel, std::size_t i,
                             int x, int y) {
    const tile& t = s.baked.tiles[i];
    const ivec2 at = texel_position(t, x, y);
    return (s.baked.atlases[t.atlas].*channel).pixel(at.x, at.y);
}

ivec2 upright(const baked_scene& s) {
    const tile& t = s.baked.tiles[0];
    return t.is_rotated ? ivec2(t.height, t.width) : ivec2(t.width, t.height);
}

double opaque_texels(const baked_scene& s) {
    double count = 0;
    for (const atlas& a : s.baked.atlases) {
        for (std::size_t i = 3; i < a.base_color.bytes.size(); i += 4) {
            count += a.base_color.bytes[i] == 255;
        }
    }
    return count;
}

mesh leaves(std::size_t faces) {
    mesh m = leaf_soup(faces, {.edge = 0.2f});
    image leaf = image::filled(64, 64, 4, 0);
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            const int dx = 2 * x - 63;
            const int dy = 2 * y - 63;
            std::uint8_t* p = leaf.pixel(x, y);
            p[0] = static_cast<std::uint8_t>(60 + x);
            p[1] = static_cast<std::uint8_t>(120 + y);
            p[2] = 30;
            p[3] = dx * dx + dy * dy < 63 * 63 ? 255 : 0;
            if (p[3] == 0) p[0] = p[1] = p[2] = 255;  // a background that must not be seen
        }
    }
    m.materials = {{.metallic = 0, .is_double_sided = true}};
    give_texture(m, leaf, alpha_mode::mask);
    return m;
}

}  // namespace

TEST_SUITE("bake/bake_cloud") {
    TEST_CASE("a flat textured quad bakes to its texture") {
        random_stream random(1);
        for (const bool is_tall : {false, true}) {
            const ivec2 size = is_tall ? ivec2(24, 64) : ivec2(64, 24);
            image picture = image::filled(size.x, size.y, 4, 255);
            for (auto& byte : picture.bytes) byte = static_cast<std::uint8_t>(random.unit() * 256);
            for (std::size_t i = 3; i < picture.bytes.size(); i += 4) picture.bytes[i] = 255;
            mesh m = quad(static_cast<float>(size.x) / 64, static_cast<float>(size.y) / 64);
            give_texture(m, picture);
            const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 128});
            CHECK(s.baked.texel_size == doctest::Approx(1.0 / 64));
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) {
                    const std::uint8_t* baked = texel_of(s, &atlas::base_color, 0, x, y);
                    REQUIRE(baked[3] == 255);
                    // Where the quad's diagonal runs, a texel is the mean of its two parts' centres.
                    const double across = (x + 0.5) / size.x + (y + 0.5) / size.y - 1;
                    const bool is_split = std::abs(across) < 0.5 / size.x + 0.5 / size.y;
                    for (int c = 0; c < 3; ++c) {
                        const int off = std::abs(baked[c] - picture.pixel(x, y)[c]);
                        REQUIRE(off <= (is_split ? 80 : 1));
                    }
                }
            }
            CHECK(s.baked.atlases[0].normal.empty());
            CHECK(s.baked.atlases[0].occlusion_roughness_metallic.empty());
            CHECK(s.baked.atlases[0].emissive.empty());
        }
    }

    TEST_CASE("every texel covers the same square, and the billboard ends with its tile") {
        const mesh m = leaves(300);
        const auto before = cloud_on(m, three_walls(), 0.3, 1.1);
        const auto s = bake(m, before, {.texels = 150});
        for (std::size_t i = 0; i < 3; ++i) {
            const billboard& b = s.cloud.billboards[i];
            const tile& t = s.baked.tiles[i];
            const double width = t.is_rotated ? t.height : t.width;
            const double height = t.is_rotated ? t.width : t.height;
            CHECK(b.width == doctest::Approx(width * s.baked.texel_size));
            CHECK(b.height == doctest::Approx(height * s.baked.texel_size));
            // Cropped to what is opaque: never wider than the faces and a texel, and within them.
            CHECK(b.width < before.billboards[i].width + s.baked.texel_size);
            const billboard& whole = before.billboards[i];
            for (const dvec2 st : {dvec2(0, 0), dvec2(1, 1)}) {
                const dvec3 corner =
                    b.origin + b.axes.u * (st.x * b.width) + b.axes.v * (st.y * b.height);
                const dvec2 at(glm::dot(corner - whole.origin, whole.axes.u),
                               glm::dot(corner - whole.origin, whole.axes.v));
                CHECK(at.x > -s.baked.texel_size);
                CHECK(at.x < whole.width + s.baked.texel_size);
                CHECK(at.y > -s.baked.texel_size);
                CHECK(at.y < whole.height + s.baked.texel_size);
            }
        }
        CHECK(s.baked.texel_size == doctest::Approx(2.2 / 150));
    }

    TEST_CASE("a tile that does not fit makes all texels coarser") {
        const mesh m = textured_cube(16);
        const auto s =
            bake(m, cloud_on(m, box_planes(), 0.01, 0.9), {.texels = 1000, .max_atlas = 128});
        CHECK(s.baked.texel_size == doctest::Approx(1.0 / 112));
        CHECK(s.baked.atlases.size() == 6);
        for (const atlas& a : s.baked.atlases) CHECK(std::max(a.width(), a.height()) <= 128);
    }

    TEST_CASE("tiles with their padding do not overlap, alpha is 0 or 255") {
        const mesh m = leaves(400);
        const auto s = bake(m, cloud_on(m, three_walls(), 0.3, 1.1), {.texels = 128});
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                const tile& a = s.baked.tiles[i];
                const tile& b = s.baked.tiles[k];
                const bool is_apart = a.x + a.width + 16 <= b.x || b.x + b.width + 16 <= a.x ||
                                      a.y + a.height + 16 <= b.y || b.y + b.height + 16 <= a.y;
                CHECK((a.atlas != b.atlas || is_apart));
            }
        }
        bool is_binary = true;
        for (const atlas& a : s.baked.atlases) {
            for (std::size_t i = 3; i < a.base_color.bytes.size(); i += 4) {
                is_binary &= a.base_color.bytes[i] == 0 || a.base_color.bytes[i] == 255;
            }
        }
        CHECK(is_binary);
        CHECK(opaque_texels(s) > 500);
    }

    TEST_CASE("no texel anywhere shows the background of the leaf texture") {
        const mesh m = leaves(200);
        const auto s = bake(m, cloud_on(m, three_walls(), 0.3, 1.1), {.texels = 256});
        int brightest_blue = 0;
        int least_green = 255;
        for (const atlas& a : s.baked.atlases) {
            for (std::size_t i = 0; i < a.base_color.bytes.size(); i += 4) {
                brightest_blue = std::max<int>(brightest_blue, a.base_color.bytes[i + 2]);
                least_green = std::min<int>(least_green, a.base_color.bytes[i + 1]);
            }
        }
        CHECK(brightest_blue <= 31);
        CHECK(least_green >= 119);
    }

    TEST_CASE("the opaque area is the projected area") {
        // Discs that do not overlap, tilted against their plane.
        mesh m = leaves(2);
        m.positions = {
            {-0.8f, -0.5f, -0.2f}, {0.8f, -0.5f, 0.2f}, {0.8f, 0.5f, 0.2f}, {-0.8f, 0.5f, -0.2f}};
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.3, 1), {.texels = 256});
        double texels = 0;  // of the leaf's picture
        for (std::size_t i = 3; i < m.images[0].bytes.size(); i += 4) {
            texels += m.images[0].bytes[i] != 0;
        }
        const double ellipse = texels / (64 * 64) * 1.6 * 1.0;
        const double area = opaque_texels(s) * s.baked.texel_size * s.baked.texel_size;
        CHECK(area == doctest::Approx(ellipse).epsilon(0.01));
        CHECK(s.baked.opaque_area == opaque_texels(s));
        // The leaf's own area, as an option.
        const auto whole = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.3, 1),
                                {.texels = 256, .alpha = {.area = opaque_area::surface}});
        CHECK(whole.baked.opaque_area ==
              doctest::Approx(s.baked.opaque_area * std::sqrt(0.64 + 0.04) / 0.8).epsilon(0.01));
    }

    TEST_CASE("one, two and three threads give the same bytes") {
        const mesh m = leaves(500);
        const auto cloud = cloud_on(m, three_walls(), 0.3, 1.1);
        const auto a = bake(m, cloud, {.texels = 200}, {1});
        for (const unsigned threads : {2u, 3u}) {
            const auto b = bake(m, cloud, {.texels = 200}, {threads});
            REQUIRE(a.baked.atlases.size() == b.baked.atlases.size());
            CHECK(a.baked.atlases[0].base_color == b.baked.atlases[0].base_color);
            CHECK(a.baked.atlases[0].normal == b.baked.atlases[0].normal);
        }
    }

    TEST_CASE("baked normals give the scene's normals back, in turned tiles too") {
        for (const bool is_tall : {false, true}) {
            mesh m = is_tall ? quad(0.3f, 1.6f) : quad(1.6f, 0.3f);
            const vec3 tilted = glm::normalize(vec3(0.3f, -0.5f, 0.7f));
            m.normals.assign(4, tilted);
            // A second, lying quad makes the packer turn one of the two.
            mesh other = is_tall ? quad(1.6f, 0.3f) : quad(0.3f, 1.6f);
            for (const vec3& p : other.positions) m.positions.push_back(p + vec3(0, 0, 0.5f));
            for (const vec2& uv : other.uv_sets[0]) m.uv_sets[0].push_back(uv);
            m.normals.insert(m.normals.end(), 4, tilted);
            m.triangles.push_back({4, 5, 6});
            m.triangles.push_back({4, 6, 7});
            const auto s =
                bake(m, cloud_on(m, {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.5}}, 0.1, 1), {.texels = 64});
            CHECK(s.baked.tiles[0].is_rotated != s.baked.tiles[1].is_rotated);
            const mesh cards = cloud_mesh(s.cloud, s.baked);
            for (std::size_t i = 0; i < 2; ++i) {
                const std::uint8_t* n = texel_of(s, &atlas::normal, i, 2, 2);
                CHECK(n[2] >= 128);
                const vec3 local = vec3(n[0], n[1], n[2]) / 127.5f - 1.0f;
                const vec3 normal = cards.normals[4 * i];
                const vec4 tangent = cards.tangents[4 * i];
                const vec3 bitangent = glm::cross(normal, vec3(tangent)) * tangent.w;
                const vec3 scene = vec3(tangent) * local.x + bitangent * local.y + normal * local.z;
                CHECK(glm::distance(scene, tilted) < 0.02f);
            }
        }
    }

    TEST_CASE("normals behind the plane are turned or kept at the horizon") {
        mesh m = quad(1, 1);
        m.normals.assign(4, glm::normalize(vec3(0.6f, 0, -0.8f)));
        auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        const std::uint8_t* turned = texel_of(s, &atlas::normal, 0, 3, 3);
        CHECK(std::abs(turned[0] - 51) <= 1);
        CHECK(std::abs(turned[2] - 230) <= 1);
        m.materials[0].is_double_sided = false;
        s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        const std::uint8_t* kept = texel_of(s, &atlas::normal, 0, 3, 3);
        CHECK(kept[0] >= 254);
        CHECK(kept[2] == 128);
    }

    TEST_CASE("a normal map is carried over, whatever way its uvs are turned") {
        mesh m = quad(1, 1);
        m.uv_sets[0] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};  // u runs up, v to the right
        image bumps = image::filled(4, 4, 3, 128);
        for (std::size_t i = 0; i < bumps.bytes.size(); i += 3) {
            bumps.bytes[i] = 204;  // 0.6 towards +u
            bumps.bytes[i + 2] = 230;
        }
        m.images = {bumps};
        m.materials[0].normal_texture = {.image = 0};
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        const std::uint8_t* n = texel_of(s, &atlas::normal, 0, 5, 5);
        CHECK(std::abs(n[0] - 128) <= 1);
        CHECK(std::abs(n[1] - 204) <= 1);
    }

    TEST_CASE("valid faces of other planes are drawn too, and enlarge nothing") {
        mesh m = quad(1, 1);
        const mesh other = quad(1, 1);
        for (const vec3& p : other.positions) m.positions.push_back(p + vec3(0.5f, 0, 0.05f));
        m.uv_sets[0].clear();
        m.triangles.push_back({4, 5, 6});
        m.triangles.push_back({4, 6, 7});
        m.materials = {{.base_color = vec4(1, 0, 0, 1), .metallic = 0},
                       {.base_color = vec4(0, 1, 0, 1), .metallic = 0}};
        m.face_materials = {0, 0, 1, 1};
        auto cloud = cloud_on(m, {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.05}}, 0.1, 1);
        // The other quad lies above the depth of the mapped faces: clipped.
        auto s = bake(m, cloud, {.texels = 64});
        CHECK(texel_of(s, &atlas::base_color, 0, 30, 10)[0] == 255);
        // Within the depth it covers its half.
        cloud.billboards[0].depth_high = 0.06;
        s = bake(m, cloud, {.texels = 64});
        CHECK(upright(s) == ivec2(32, 32));
        CHECK(texel_of(s, &atlas::base_color, 0, 10, 10)[0] == 255);
        CHECK(texel_of(s, &atlas::base_color, 0, 30, 10)[1] == 255);
        s = bake(m, cloud, {.texels = 64, .draw = {.max_extra_angle = 0}});
        CHECK(texel_of(s, &atlas::base_color, 0, 30, 10)[0] == 255);
    }

    TEST_CASE("a plane with only also-drawn faces shows them, even those between all samples") {
        for (const float height : {1.0f, 1e-6f}) {
            mesh m = quad(1, height);
            billboard_cloud cloud = cloud_on(m, {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.01}}, 0.1, 1);
            cloud.also_drawn = {{1, 0}, {1, 1}};
            fit_billboards(m, cloud);
            const auto s = bake(m, cloud, {.texels = 32, .draw = {.max_extra_angle = 0}});
            for (const std::size_t i : {0u, 1u}) {
                int opaque = 0;
                const tile& t = s.baked.tiles[i];
                for (int y = 0; y < t.height; ++y) {
                    for (int x = 0; x < t.width; ++x) {
                        const image& color = s.baked.atlases[t.atlas].base_color;
                        opaque += color.pixel(t.x + x, t.y + y)[3] == 255;
                    }
                }
                CHECK(opaque >= (height == 1.0f ? 200 : 1));
            }
        }
    }

    TEST_CASE("each part has its own alpha threshold") {
        mesh m = quad(1, 1);
        give_texture(m, image::filled(4, 4, 4, 100), alpha_mode::blend);  // 39 % of the samples
        billboard_cloud cloud = cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1);
        cloud.parts = {{0.1}, {0.1}};
        bake_options options{.texels = 32, .alpha = {.area = opaque_area::thresholds}};
        options.part_thresholds = {{.foliage = 0.3}, {.foliage = 0.5}};
        for (const part_id part : {0u, 1u}) {
            cloud.part_of_plane = {part};
            CHECK((opaque_texels(bake(m, cloud, options)) > 200) == (part == 0));
        }
    }

    TEST_CASE("faces in the envelope close cracks of a teapot, and enlarge nothing") {
        const mesh pot = teapot(8);
        const auto faces = make_face_table(pot);
        REQUIRE(faces);
        billboard_cloud cloud =
            greedy_search(*faces, pot.face_count(), {.epsilon = 0.1 * faces->bounds.radius}).cloud;
        fit_billboards(pot, cloud);
        // Pixels of the original that show the background in the cloud.
        const auto missing = [&](const bake_options& options) {
            const auto s = bake(pot, cloud, options);
            CHECK(s.baked.tiles.size() == cloud.plane_count());
            for (std::size_t i = 0; i < cloud.plane_count(); ++i) {
                CHECK(s.cloud.billboards[i].width <
                      cloud.billboards[i].width + 1.01 * s.baked.texel_size);
            }
            const mesh cards = cloud_mesh(s.cloud, s.baked);
            int count = 0;
            for (const dvec3 from : {dvec3(1, 1, 1), dvec3(-2, 1, 0.5), dvec3(0.3, 0.5, -1)}) {
                const auto view = view_of(cloud.bounds, from, 256, 256);
                const picture_options blue{.background = vec3(0, 0, 1)};
                const image a = draw_picture(pot, view, blue);
                const image b = draw_picture(cards, view, blue);
                const auto is_background = [](const std::uint8_t* p) {
                    return p[0] == 0 && p[1] == 0 && p[2] == 255;
                };
                for (std::size_t i = 0; i < a.bytes.size(); i += 3) {
                    count += !is_background(&a.bytes[i]) && is_background(&b.bytes[i]);
                }
            }
            return count;
        };
        const int own = missing({.texels = 256, .draw = {.max_extra_angle = 0}});
        const int closed = missing(
            {.texels = 256, .draw = {.max_extra_angle = 0, .cracks = crack_reduction::envelope}});
        CHECK(closed < 0.75 * own);
        // Faces that are merely valid close most of them already.
        const int valid = missing({.texels = 256});
        CHECK(missing({.texels = 256, .draw = {.cracks = crack_reduction::envelope}}) <
              0.95 * valid);
        const bake_options three{.texels = 256, .draw = {.cracks = crack_reduction::envelope}};
        const auto one = bake(pot, cloud, three, {1});
        const auto many = bake(pot, cloud, three, {3});
        CHECK(one.baked.atlases[0].base_color == many.baked.atlases[0].base_color);
    }

    TEST_CASE("channels carry roughness, metal and glow where there are any") {
        mesh m = quad(1, 1);
        m.materials[0].roughness = 0.4f;
        m.materials[0].metallic = 0.8f;
        m.materials[0].emissive = vec3(0, 1, 0);
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        const std::uint8_t* orm = texel_of(s, &atlas::occlusion_roughness_metallic, 0, 4, 4);
        CHECK(orm[0] == 255);
        CHECK(orm[1] == 102);
        CHECK(orm[2] == 204);
        CHECK(texel_of(s, &atlas::emissive, 0, 4, 4)[1] == 255);
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        CHECK(cards.materials[0].metallic == 1);
        CHECK(cards.materials[0].emissive == vec3(1));
    }

    TEST_CASE("a sparse or hair-thin tile keeps at least one texel") {
        mesh thin = quad(1, 1e-6f);
        auto s = bake(thin, cloud_on(thin, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        CHECK(opaque_texels(s) >= 1);
        mesh faint = quad(1, 1);
        give_texture(faint, image::filled(4, 4, 4, 40), alpha_mode::blend);
        s = bake(faint, cloud_on(faint, {{{0, 0, 1}, 0}}, 0.1, 1),
                 {.texels = 32, .alpha = {.area = opaque_area::thresholds}});
        CHECK(opaque_texels(s) == 1);
        mesh point = quad(1e-7f, 1e-7f);
        s = bake(point, cloud_on(point, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 32});
        CHECK(s.baked.tiles[0].width == 1);
        CHECK(opaque_texels(s) == 1);
    }

    TEST_CASE("tiles are cropped to what is opaque, and the picture stays where it was") {
        // A quad whose texture is opaque in its upper right quarter alone.
        mesh m = quad(1, 1);
        image picture = image::filled(64, 64, 4, 0);
        for (int y = 0; y < 32; ++y) {
            for (int x = 32; x < 64; ++x) picture.pixel(x, y)[3] = 255;
        }
        give_texture(m, picture, alpha_mode::mask);
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), {.texels = 128});
        CHECK(upright(s) == ivec2(32, 32));
        CHECK(opaque_texels(s) == 32 * 32);
        const billboard& b = s.cloud.billboards[0];
        CHECK(b.width == doctest::Approx(0.5));
        const dvec3 middle = b.origin + b.axes.u * (b.width / 2) + b.axes.v * (b.height / 2);
        CHECK(glm::distance(middle, dvec3(0.25, 0.25, 0)) < 1e-6);
        CHECK(s.baked.overdraw() == 0);
    }

    TEST_CASE("outlines leave less transparent area, hold all that is opaque, and are drawn") {
        const mesh m = leaves(2);  // one disc
        mesh card = m;
        card.positions = {{-.8f, -.5f, 0}, {.8f, -.5f, 0}, {.8f, .5f, 0}, {-.8f, .5f, 0}};
        const auto cloud = cloud_on(card, {{{0, 0, 1}, 0}}, 0.3, 1);
        double before = 1e9;
        for (const int corners : {0, 4, 6, 8}) {
            const auto s = bake(card, cloud, {.texels = 128, .outline_corners = corners});
            CHECK(s.baked.overdraw() <= before);
            before = s.baked.overdraw();
            const mesh cards = cloud_mesh(s.cloud, s.baked);
            CHECK(cards.face_count() <= static_cast<std::size_t>(std::max(4, corners) - 2));
            const auto view = view_of(cloud.bounds, dvec3(0, 0, 1), 128, 128);
            const image a = draw_picture(card, view);
            const image b = draw_picture(cards, view);
            double off = 0;
            for (std::size_t i = 0; i < a.bytes.size(); ++i)
                off += std::abs(a.bytes[i] - b.bytes[i]);
            CHECK(off / static_cast<double>(a.bytes.size()) < 1);
        }
        CHECK(before < 0.12);  // an octagon around an ellipse: 0.055, and the texels' corners
    }

    TEST_CASE("fewer atlases than tiles would fill make all texels coarser") {
        const mesh m = textured_cube(16);
        const bake_options many{.texels = 300, .max_atlas = 256};
        const auto a = bake(m, cloud_on(m, box_planes(), 0.01, 0.9), many);
        CHECK(a.baked.atlases.size() > 2);
        bake_options two = many;
        two.max_atlases = 2;
        const auto b = bake(m, cloud_on(m, box_planes(), 0.01, 0.9), two);
        CHECK(b.baked.atlases.size() <= 2);
        CHECK(b.baked.texel_size > b.baked.wanted_size);
        CHECK(b.baked.wanted_size == doctest::Approx(1.8 / 300));
        bake_options by_unit = many;
        by_unit.texels_per_unit = 50;
        CHECK(bake(m, cloud_on(m, box_planes(), 0.01, 0.9), by_unit).baked.texel_size ==
              doctest::Approx(0.02));
    }

    TEST_CASE("automatic sides: two tiles where the sides look different, and only there") {
        // Two cards, each of two quads back to back; the second card has two colours.
        mesh m;
        for (const float z : {0.0f, 0.02f, 1.0f, 1.02f}) {
            const mesh q = quad(1, 1);
            const auto first = static_cast<std::uint32_t>(m.vertex_count());
            for (const vec3& p : q.positions) m.positions.push_back(p + vec3(0, 0, z));
            m.triangles.push_back({first, first + 1, first + 2});
            m.triangles.push_back({first, first + 2, first + 3});
        }
        m.materials = {{.base_color = vec4(1, 0, 0, 1), .metallic = 0},
                       {.base_color = vec4(0, 1, 0, 1), .metallic = 0}};
        m.face_materials = {0, 0, 0, 0, 0, 0, 1, 1};
        const auto cloud = cloud_on(m, {{{0, 0, 1}, 0.01}, {{0, 0, 1}, 1.01}}, 0.05, 1.3);
        const auto s = bake(m, cloud, {.texels = 64, .sides = tile_sides::automatic});
        CHECK(s.baked.tiles.size() == 3);
        CHECK(s.baked.back_tile(0) == no_id);
        REQUIRE(s.baked.back_tile(1) == 2);
        CHECK(texel_of(s, &atlas::base_color, 1, 8, 8)[1] == 255);
        CHECK(texel_of(s, &atlas::base_color, 2, 8, 8)[0] == 255);
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        CHECK(cards.face_count() == 6);
        CHECK(cards.materials.size() == 2);
        CHECK(bake(m, cloud, {.texels = 64}).baked.tiles.size() == 2);
        const auto two = bake(m, cloud, {.texels = 64, .sides = tile_sides::two});
        CHECK(two.baked.tiles.size() == 4);
        const auto again = bake(m, cloud, {.texels = 64, .sides = tile_sides::two}, {3});
        CHECK(two.baked.atlases[0].base_color == again.baked.atlases[0].base_color);
    }

    TEST_CASE("a back tile is the picture from behind") {
        mesh m = quad(1, 0.5f);
        random_stream random(3);
        image picture = image::filled(32, 16, 4, 255);
        for (std::size_t i = 0; i < picture.bytes.size(); ++i) {
            if (i % 4 != 3) picture.bytes[i] = static_cast<std::uint8_t>(random.unit() * 256);
        }
        give_texture(m, picture);
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1),
                            {.texels = 64, .sides = tile_sides::two});
        REQUIRE(s.baked.tiles.size() == 2);
        int worst = 0;
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 32; ++x) {
                const std::uint8_t* front = texel_of(s, &atlas::base_color, 0, x, y);
                const std::uint8_t* back = texel_of(s, &atlas::base_color, 1, 31 - x, y);
                for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(front[c] - back[c]));
            }
        }
        CHECK(worst <= 1);
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        const bounding_sphere all{dvec3(0), 0.6};
        for (const dvec3 from : {dvec3(0, 0, 1), dvec3(0, 0, -1)}) {
            const image a = draw_picture(m, view_of(all, from, 96, 96));
            const image b = draw_picture(cards, view_of(all, from, 96, 96));
            double off = 0;
            for (std::size_t i = 0; i < a.bytes.size(); ++i)
                off += std::abs(a.bytes[i] - b.bytes[i]);
            CHECK(off / static_cast<double>(a.bytes.size()) < 4);
        }
    }

    TEST_CASE(
        "object normals are the scene's, from either side; a dome's point out of the middle") {
        mesh m = quad(1, 0.4f);
        const vec3 tilted = glm::normalize(vec3(0.3f, -0.5f, 0.7f));
        m.normals.assign(4, tilted);
        bake_options options{.texels = 64};
        options.draw.normals = normal_style::object;
        const auto cloud = cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1);
        const auto s = bake(m, cloud, options);
        const std::uint8_t* n = texel_of(s, &atlas::normal, 0, 3, 3);
        CHECK(glm::distance(vec3(n[0], n[1], n[2]) / 127.5f - 1.0f, tilted) < 0.02f);
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        REQUIRE(cards.face_count() == 4);
        CHECK_FALSE(cards.materials[0].is_double_sided);
        CHECK(cards.normals[5] == vec3(0, 0, 1));
        CHECK(cards.tangents[5] == vec4(1, 0, 0, 1));
        const auto [a, b, c] = cards.corners(2);
        CHECK(glm::cross(b - a, c - a).z < 0);

        options.draw.normals = normal_style::dome;
        options.draw.dome = 1;
        const auto round = bake(m, cloud, options);
        const ivec2 size = upright(round);
        const std::uint8_t* left = texel_of(round, &atlas::normal, 0, 0, size.y / 2);
        const std::uint8_t* right = texel_of(round, &atlas::normal, 0, size.x - 1, size.y / 2);
        CHECK(left[0] < 8);
        CHECK(right[0] > 247);
        CHECK(std::abs(left[2] - 128) <= 2);
        options.draw.part_dome = {0};
        const auto flat = bake(m, cloud, options);
        CHECK(texel_of(flat, &atlas::normal, 0, 3, 3)[2] == n[2]);
    }

    TEST_CASE("sheets give each side its own normals") {
        mesh m = quad(1, 1);
        m.materials[0].is_double_sided = true;
        m.normals.assign(4, glm::normalize(vec3(0.6f, 0, 0.8f)));
        bake_options options{.texels = 32};
        options.draw.normals = normal_style::sheets;
        const auto s = bake(m, cloud_on(m, {{{0, 0, 1}, 0}}, 0.1, 1), options);
        REQUIRE(s.baked.tiles.size() == 2);
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        for (const std::size_t i : {0u, 1u}) {
            const std::uint8_t* n = texel_of(s, &atlas::normal, i, 3, 3);
            const vec3 local = vec3(n[0], n[1], n[2]) / 127.5f - 1.0f;
            const vec3 normal = cards.normals[4 * i];
            const vec4 tangent = cards.tangents[4 * i];
            const vec3 scene = vec3(tangent) * local.x +
                               glm::cross(normal, vec3(tangent)) * tangent.w * local.y +
                               normal * local.z;
            const vec3 expected = m.normals[0] * (i == 0 ? 1.0f : -1.0f);
            CHECK(glm::distance(scene, expected) < 0.02f);
        }
    }

    TEST_CASE("no faces give no atlas") {
        const mesh none;
        const auto s = bake(none, {}, {});
        CHECK(s.baked.atlases.empty());
        CHECK(cloud_mesh(s.cloud, s.baked).face_count() == 0);
    }

    TEST_CASE("the cloud of a textured cube looks like the cube") {
        const mesh cube = textured_cube(64);
        const bounding_sphere bounds{dvec3(0), 0.8661};
        const auto s =
            bake(cube, cloud_on(cube, box_planes(), 0.01, bounds.radius), {.texels = 512});
        const mesh cards = cloud_mesh(s.cloud, s.baked);
        for (const dvec3 from :
             {dvec3(1, 1, 1), dvec3(-1, 0.3, 2), dvec3(0.2, -1, -0.7), dvec3(0, 0, 1),
              dvec3(-1, 0, 0), dvec3(0, 1, 0), dvec3(0, -1, 0)}) {
            const auto view = view_of(bounds, from, 200, 200);
            const image a = draw_picture(cube, view);
            const image b = draw_picture(cards, view);
            double sum = 0;
            int differing = 0;
            for (std::size_t i = 0; i < a.bytes.size(); ++i) {
                const int d = std::abs(a.bytes[i] - b.bytes[i]);
                sum += d;
                differing += d > 24;
            }
            CAPTURE(from.x);
            CAPTURE(from.y);
            CHECK(sum / static_cast<double>(a.bytes.size()) < 0.5);
            CHECK(differing < 0.01 * static_cast<double>(a.bytes.size()));
        }
    }
    TEST_CASE("rays darken what is hidden and give a horizon; without rays there is none") {
        mesh m;  // two squares that look up, one close above the other
        for (const float y : {0.0f, 0.1f}) {
            const auto first = static_cast<std::uint32_t>(m.vertex_count());
            for (const vec2& p : {vec2(-1, -1), vec2(-1, 1), vec2(1, 1), vec2(1, -1)}) {
                m.positions.emplace_back(p.x, y, p.y);
            }
            m.triangles.push_back({first, first + 1, first + 2});
            m.triangles.push_back({first, first + 2, first + 3});
        }
        const std::vector<plane> planes{{{0, 1, 0}, 0}, {{0, 1, 0}, 0.1}};
        bake_options options{.texels = 64};
        const auto bake_lower = [&] {
            return bake(m, cloud_on(m, planes, 0.01, 1.5), options).baked;
        };
        const baked_cloud plain = bake_lower();
        CHECK(plain.atlases[0].occlusion_roughness_metallic.empty());
        CHECK(plain.atlases[0].horizon.empty());
        options.occlusion.rays = 64;
        options.draw.with_horizon = true;
        const baked_cloud dark = bake_lower();
        const atlas& in = dark.atlases[0];
        const auto middle_of = [](const tile& t) {
            return ivec2(t.x + t.width / 2, t.y + t.height / 2);
        };
        const ivec2 hidden = middle_of(dark.tiles[0]);
        const ivec2 top = middle_of(dark.tiles[1]);
        CHECK(in.occlusion_roughness_metallic.pixel(hidden.x, hidden.y)[0] < 60);
        CHECK(in.occlusion_roughness_metallic.pixel(top.x, top.y)[0] == 255);
        const horizon_cone sky = decode_horizon(in.horizon.pixel(top.x, top.y));
        CHECK(sky.axis.y > 0.98f);
        CHECK(sky.cosine == doctest::Approx(0).epsilon(0.01));
        CHECK(decode_horizon(in.horizon.pixel(hidden.x, hidden.y)).cosine > 0.6f);
    }
}
