#pragma once
// Renderer: grey pictures of base and walker with exact sub-pixel edges, exposure blur, uneven light and
// sensor noise.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker::simulated {

/// Positions of base and walker along the shaker's axis, m.
struct Pose {
    double base = 0;
    double walker = 0;
};

/// Positions of the objects in a picture, px, for base and walker at 0. Used by the renderer and by the
/// placement of regions of interest.
struct PictureLayout {
    double centre_x;                 // image x of position 0
    double base_px_per_m;            // scale in the base's plane
    double walker_px_per_m;          // rows of the base's strip
    double marks_top, marks_bottom;  // rows of the base's strip
    double walker_y;                 // centre row of the disc or silhouette
    double walker_half_width;        // radius, or half the width of the silhouette
    double walker_half_height;
};
PictureLayout layout_of(const CameraTruth& camera, const WalkerTruth& walker);

/// Image of one camera. Deterministic: the noise depends only on the seed, the camera and the tick.
class Renderer {
public:
    Renderer(const CameraTruth& camera, const WalkerTruth& walker, std::uint64_t seed);
    /// Sets `pixels` (width * height bytes) to the mean over `poses`, which sample the exposure. walker:
    /// whether the walker is visible.
    void render(std::span<const Pose> poses, CameraTick tick, std::span<std::byte> pixels,
                bool walker = true);

private:
    [[nodiscard]] bool moves(std::span<const Pose> poses) const noexcept;
    void draw(const Pose& pose, float weight, bool walker);
    void draw_marks(double shift_px, float weight);
    void draw_code(double shift_px, float weight);
    void draw_disc(double centre_px, float weight);
    void draw_silhouette(double centre_px, float weight);
    [[nodiscard]] float edge(double distance_px) const noexcept;
    [[nodiscard]] float row_ground() const noexcept;
    [[nodiscard]] std::span<float> row_of(int y, int x0, int x1) noexcept;  // both ends included

    CameraTruth camera_;
    View truth_;
    PictureLayout layout_;
    std::vector<double> columns_;  // where each column lies on the base, px of its scale at the middle
    double mark_px_;               // diameter of a dot, or width of a bar
    double pitch_px_;
    std::vector<double> code_px_;  // edges of bars of irregular width, from the base's middle
    double wide_ = 0;              // px on either side of an edge that are grey
    std::uint64_t seed_;
    std::vector<float> light_;  // brightness of each column
    std::vector<float> erf_;    // edge spread function, tabulated
    std::vector<float> noise_;
    std::vector<float> scene_;    // reflectance, 0..1
    std::vector<float> profile_;  // one row of marks
    std::vector<double> along_;   // px of each column from the nearest mark
};

}  // namespace shaker::simulated
