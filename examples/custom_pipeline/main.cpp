// A pipeline of one's own: what a walker sees of a tree.
//
// Who walks through a forest never looks at a tree from above, so that planes which stand upright
// serve best, and mostly sees the outside of its crown. The three parts below say so. None of them
// has a base class or is registered anywhere; the compiler checks each against its concept and
// inlines it into the kernels.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <billow/billow.hpp>

using billow::dvec2;
using billow::dvec3;
using billow::orientation_id;

/// A plane space: the upright planes alone, 2N normals around the horizon. A cell of normals is a
/// step of the angle, the chart coordinate u; v has no meaning here and moves nothing.
class upright_ring {
public:
    explicit upright_ring(int half_count = 36) : half_count_(half_count) {}

    std::size_t orientation_count() const noexcept { return 2 * std::size_t(half_count_); }
    dvec3 direction(orientation_id id) const noexcept { return direction_at(0, patch(id).centre); }
    /// (n, rho) and (-n, -rho) are the same plane: every space pairs its normals.
    orientation_id antipode(orientation_id id) const noexcept {
        return around(int(id) + half_count_);
    }
    orientation_id orientation_of(const dvec3& n) const noexcept {
        return around(int(std::lround(std::atan2(n.x, n.z) / step())));
    }
    billow::orientation_list neighbours(orientation_id id) const noexcept {
        billow::orientation_list list;
        list.add_once(around(int(id) - 1));
        list.add_once(around(int(id) + 1));
        return list;
    }
    /// The part of the chart that a cell covers; refinement halves it again and again.
    billow::orientation_patch patch(orientation_id id) const noexcept {
        return {.chart = 0, .centre = {id * step(), 0}, .half_size = {step() / 2, step() / 2}};
    }
    dvec3 direction_at(int, const dvec2& uv) const noexcept {
        return {std::sin(uv.x), 0, std::cos(uv.x)};
    }
    billow::orientation_cell cell(orientation_id id) const noexcept {
        return billow::cell_of_patch(*this, patch(id));
    }

private:
    double step() const noexcept { return std::numbers::pi / half_count_; }
    orientation_id around(int i) const noexcept {
        return orientation_id((i + 4 * half_count_) % (2 * half_count_));
    }
    int half_count_;
};
static_assert(billow::plane_space<upright_ring>);

/// A contribution: the area that a plane shows of a face, which counts less the deeper the face lies
/// in the crown. At most the area, and the same for n and -n. V is a float or a pack of floats.
struct outside_first {
    float radius;              ///< of the whole model, scene units
    float inner_worth = 0.3f;  ///< of a face in the middle, 0 to 1

    template <class V>
    V operator()(const billow::face_lanes<V>& face,
                 const billow::vec3_lanes<V>& normal) const noexcept {
        const V one = billow::simd::lanes<V>::fill(1);
        const V outward = billow::simd::min(face.reach / radius, one);
        const V shown = billow::projected_area{}(face, normal);
        return shown * (inner_worth + (1 - inner_worth) * outward);
    }
};
static_assert(billow::contribution<outside_first, billow::simd::wide>);

/// A fitter: moves the plane midway between the outermost of its faces' corners, the offset of least
/// largest distance. The normal stays, so planes stay upright.
struct midway_fit {
    static constexpr bool allows_less_contribution = false;

    billow::plane operator()(const billow::face_table& faces, const billow::plane& start) const {
        if (faces.size == 0) return start;
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const billow::columns3& corner : faces.corner) {
            for (std::size_t row = 0; row < faces.size; ++row) {
                const double offset = glm::dot(start.normal, corner.get(row));
                low = std::min(low, offset);
                high = std::max(high, offset);
            }
        }
        return {start.normal, (low + high) / 2};
    }
};
static_assert(billow::plane_fitter<midway_fit>);

static void print(const char* name, const billow::build_result& built) {
    const auto upright = std::ranges::count_if(
        built.cloud.planes, [](const billow::plane& p) { return std::abs(p.normal.y) < 0.01; });
    const std::size_t planes = built.cloud.plane_count();
    std::printf("%-8s %6zu %7.0f%% %14.2f %16.2f %8.2f\n", name, planes,
                100.0 * double(upright) / double(planes),
                built.errors.mean_error / built.cloud.epsilon, built.errors.projected_area_share,
                built.search_seconds);
}

int main() {
    const auto tree = billow::tree_of_about(5000, 3);
    if (!tree) return std::fprintf(stderr, "%s\n", tree.error().message.c_str()), 1;
    const billow::build_options options{.epsilon = billow::tolerance::of_radius(0.1),
                                        .bake = {.texels = 128}};
    const auto usual = billow::build_cloud(*tree, options);
    if (!usual) return std::fprintf(stderr, "%s\n", usual.error().message.c_str()), 1;

    // Here the parts come together. Other validities and penalties go in the same way.
    const billow::pipeline walker{
        upright_ring(36),
        billow::density_policies{billow::hull_of_samples{},
                                 outside_first{.radius = float(usual->cloud.bounds.radius)},
                                 billow::inner_side_penalty{.weight = 1}},
        midway_fit{}};
    // Fewer normals to choose from: more planes for the same epsilon, found in less time.
    const auto own = billow::build_cloud(*tree, options, walker);
    if (!own) return std::fprintf(stderr, "%s\n", own.error().message.c_str()), 1;

    std::puts("pipeline planes  upright mean error/eps  projected share search s");
    print("default", *usual);
    print("walker", *own);
}
