#pragma once
// TextureBank: compares raw pixels with a texture at tabulated shifts, block by block.
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "tracking/image/pixels.hpp"

namespace shaker::tracking {

/// A part of an image that can be shifted by fractions of a pixel. Cubic B-spline through the pixels of a
/// box, evaluated on the box's grid shifted by up to one pixel. Needs five pixels around the box; they are
/// mirrored at the edge of the image.
class Texture {
public:
    Texture() = default;
    Texture(const ImageView& image, const Box& box);
    /// Sets value, d/dx and d/dy at every pixel p of the box to the texture at p - shift, |shift| <= 1.
    void shift(Point shift);
    [[nodiscard]] const Box& box() const noexcept { return box_; }
    [[nodiscard]] int width() const noexcept { return box_.x1 - box_.x0; }
    [[nodiscard]] int height() const noexcept { return box_.y1 - box_.y0; }
    [[nodiscard]] const double* value(int y) const noexcept { return value_.data() + at(y); }
    [[nodiscard]] const double* dx(int y) const noexcept { return dx_.data() + at(y); }
    [[nodiscard]] const double* dy(int y) const noexcept { return dy_.data() + at(y); }
    /// The derivatives of the texture smoothed by a binomial of 5 px. Their noise is independent of that of
    /// value(), so weighting residuals with them causes no bias towards half pixels.
    [[nodiscard]] const double* smooth_dx(int y) const noexcept { return smooth_dx_.data() + at(y); }
    [[nodiscard]] const double* smooth_dy(int y) const noexcept { return smooth_dy_.data() + at(y); }

private:
    [[nodiscard]] std::size_t at(int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width());
    }
    static constexpr int margin = 5;
    Box box_;
    void evaluate(const std::vector<double>& coefficients, Point shift, double* value, double* dx,
                  double* dy);

    std::vector<double> coefficients_, smooth_;  // of the box with its margin
    std::vector<double> row_value_, row_dx_, value_, dx_, dy_, smooth_value_, smooth_dx_, smooth_dy_;
};

/// Tables are filled when a shift first occurs. Not thread-safe.
class TextureBank {
public:
    static constexpr int steps = 8;  // places a px, in x and in y
    /// A shift of the texture, in 1/steps px.
    struct Place {
        int x = 0, y = 0;
        [[nodiscard]] Point shift() const noexcept { return {double(x) / steps, double(y) / steps}; }
    };
    /// Sums over pixels of products of the texture T, its derivatives, its smooth derivatives and the picture
    /// I. Grey levels count from the mean of T.
    struct Sums {
        Eigen::Matrix<double, 6, 6> own;      // 1, T, dT/dx, dT/dy, the smooth derivatives with themselves
        Eigen::Matrix<double, 5, 1> picture;  // I with 1, T, the smooth derivatives and I
        /// Correlation of texture and picture.
        [[nodiscard]] double likeness() const noexcept;
    };
    /// The same for a body that moves in several ways: T and the smooth derivatives along each way.
    template <int ways>
    struct Motion {
        Eigen::Matrix<double, 2, ways> across =
            Eigen::Matrix<double, 2, ways>::Zero();  // 1, T with the derivatives of T
        Eigen::Matrix<double, ways, 2> seen =
            Eigen::Matrix<double, ways, 2>::Zero();  // the smooth derivatives with 1, T
        Eigen::Matrix<double, ways, 1> picture = Eigen::Matrix<double, ways, 1>::Zero();
        Eigen::Matrix<double, ways, ways> own = Eigen::Matrix<double, ways, ways>::Zero(),
                                          spread = own;  // with those of T, with themselves
    };

    TextureBank() = default;
    explicit TextureBank(Texture texture);
    [[nodiscard]] const Texture& texture() const noexcept { return texture_; }
    [[nodiscard]] int blocks() const noexcept { return static_cast<int>(blocks_.size()); }
    [[nodiscard]] static Place nearest(Point shift) noexcept;
    /// Fills the tables of all places along an axis, and of those one step beside it.
    void learn(Axis axis);
    /// Compares the picture with the texture at a place, in one block of `every`. A block that is not wholly
    /// in the picture does not count. Returns false when no block counts.
    bool compare(const ImageView& image, Place place, int every = 1);
    /// Sums over the compared blocks that are in use.
    [[nodiscard]] Sums sums() const noexcept;
    /// way(p): the shifts of a block whose middle is at p, px from the texture's middle, a column for each
    /// way.
    template <int ways, class Way>
    [[nodiscard]] Motion<ways> motion(Way way) const noexcept {
        Motion<ways> all;
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            if (!use_[b].compared || !use_[b].used) continue;
            const Block& block = blocks_[b];
            const Eigen::Matrix<double, 2, ways> u =
                way(Point{block.x + 0.5 * (block.columns - texture_.width()),
                          block.y + 0.5 * (block.rows - texture_.height())});
            const Sums& s = now_->sums[b];
            all.across += s.own.template block<2, 2>(0, 2) * u;
            all.seen += u.transpose() * s.own.template block<2, 2>(4, 0);
            all.picture += u.transpose() * s.picture.template segment<2>(2);
            all.own += u.transpose() * s.own.template block<2, 2>(4, 2) * u;
            all.spread += u.transpose() * s.own.template block<2, 2>(4, 4) * u;
        }
        return all;
    }
    /// Puts all blocks in use.
    void use_all() noexcept;
    /// Uses the blocks that I = offset + gain T fits about as well as half of them. Returns the share of the
    /// texture in use.
    double weigh(double gain, double offset) noexcept;
    /// The shift of whole pixels near `start` at which one block of `every` correlates best. step: px, by
    /// which the first shifts differ; it is halved down to 1.
    [[nodiscard]] Point climb(const ImageView& image, Point start, int step, int every);

private:
    static constexpr int side = 8;                          // px, of a block
    static constexpr std::size_t texels = 3 * side * side;  // numbers of a block in a table
    struct Block {
        int x = 0, y = 0, columns = 0, rows = 0;
    };
    // One place, all blocks.
    struct Table {
        float* values = nullptr;  // T and its smooth derivatives, row by row of each block
        Sums* sums = nullptr;     // the picture's are those of the newest one
        bool known = false;
    };
    struct Use {
        bool compared = false, used = false;
        double misfit = 0;
    };
    Table& table_at(Place place);  // fills it
    void learn(Table& table, Point shift);

    Texture texture_;
    float level_ = 0;
    std::vector<Block> blocks_;
    std::vector<Table> tables_;
    std::unique_ptr<float[]> values_;  // memory of all tables; a part is used when its place occurs
    std::unique_ptr<Sums[]> sums_;
    std::vector<Use> use_;
    std::vector<double> sorted_;
    Table* now_ = nullptr;  // of the newest comparison
};

}  // namespace shaker::tracking
