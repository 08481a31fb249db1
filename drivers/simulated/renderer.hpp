#pragma once
// Base and walker to grey pictures: exact sub-pixel edges, exposure blur, uneven light, sensor noise.
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/data.hpp"
#include "drivers/simulated/scene.hpp"

namespace shaker {

/// Positions of base and walker along the shaker's axis, m.
struct Pose {
    double base = 0;
    double walker = 0;
};

/// Where things are in a picture, px, with base and walker at 0: shared by the renderer and by what places
/// the regions of interest.
struct PictureLayout {
    double centre_x;                 // image x of position 0
    double base_px_per_m;            // scale in the base's plane
    double walker_px_per_m;          // scale in the walker's plane
    double marks_top, marks_bottom;  // rows of the base's strip
    double walker_y;                 // centre of the disc, or of the silhouette
    double walker_half_width;        // radius, or half of the silhouette's width
    double walker_half_height;
};
PictureLayout layout_of(const CameraTruth& camera, const WalkerTruth& walker);

/// One camera's eye. Deterministic: noise depends on the seed, the camera and the frame's tick only.
class Renderer {
public:
    Renderer(const CameraTruth& camera, const WalkerTruth& walker, std::uint64_t seed);
    /// Fills `pixels` (width * height bytes) with the mean over `poses`, which sample the exposure; without a
    /// walker where none is to be seen.
    void render(std::span<const Pose> poses, CameraTick tick, std::span<std::byte> pixels,
                bool walker = true);

private:
    [[nodiscard]] bool moves(std::span<const Pose> poses) const noexcept;
    void draw(const Pose& pose, float weight, bool walker);
    void draw_marks(double shift_px, float weight);
    void draw_disc(double centre_px, float weight);
    void draw_silhouette(double centre_px, float weight);
    [[nodiscard]] float edge(double distance_px) const noexcept;
    [[nodiscard]] float row_ground() const noexcept;

    CameraTruth camera_;
    PictureLayout layout_;
    double mark_px_;  // diameter of a dot, width of a bar
    double pitch_px_;
    std::uint64_t seed_;
    std::vector<float> light_;  // brightness of each column
    std::vector<float> erf_;    // edge spread function, tabulated
    std::vector<float> noise_;
    std::vector<float> scene_;    // reflectance, 0..1
    std::vector<float> profile_;  // one row of marks
};

}  // namespace shaker
