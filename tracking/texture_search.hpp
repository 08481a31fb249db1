#pragma once
// TextureSearch: finds what resembles a texture in reduced pictures.
#include <opencv2/core.hpp>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// Possible shift of a texture, to about half a cell. score: correlation, 1 at most.
struct TexturePeak {
    Point shift;
    double score = 0;
};

/// Pixels of the reduced pictures are means of cells, as large as the texture's detail allows.
class TextureSearch {
public:
    TextureSearch() = default;
    /// The texture in a box of frame 0.
    TextureSearch(const ImageView& image, const Box& box);
    /// Replaces `out` by the local maxima of at least `least`, best first, at most 24, for shifts in a box; a
    /// texture that would not be whole in the picture is not looked for.
    void scan(const ImageView& image, const Box& shifts, double least, std::vector<TexturePeak>& out) const;
    /// px, side of a cell.
    [[nodiscard]] int cell() const noexcept { return cell_; }
    /// px, side of a box of shifts that scan() covers in about 0.1 ms.
    [[nodiscard]] int tile() const noexcept;

private:
    Box box_;  // of the texture that is compared, in frame 0
    int cell_ = 1;
    cv::Mat1f texture_;  // reduced
};

}  // namespace shaker::tracking
