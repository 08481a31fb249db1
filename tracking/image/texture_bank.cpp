#include "tracking/image/texture_bank.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace shaker::tracking {
namespace {

constexpr double misfit_of_half = 6;      // times the median of the blocks, above which a block is not used
constexpr int most_moves = 4;             // of a climb, with each step
constexpr double rounding_squared = 0.5;  // of grey levels

using Eight [[gnu::vector_size(32)]] = float;

// Eight values, of which `count` are there; the others are 0.
template <class T>
void take(const T* from, int count, Eight& to) noexcept {
    using Narrow [[gnu::vector_size(8 * sizeof(T))]] = T;
    Narrow all{};
    if (count == 8)
        std::memcpy(&all, from, sizeof all);
    else
        std::memcpy(&all, from, static_cast<std::size_t>(count) * sizeof(T));
    to = __builtin_convertvector(all, Eight);
}

double sum_of(const Eight& v) noexcept {
    double sum = 0;
    for (int i = 0; i < 8; ++i) sum += static_cast<double>(v[i]);
    return sum;
}

}  // namespace

double TextureBank::Sums::likeness() const noexcept {
    const double n = own(0, 0), t = own(0, 1), i = picture[0];
    const double spread = (own(1, 1) - t * t / n) * (picture[4] - i * i / n);
    return spread > 0 ? (picture[1] - t * i / n) / std::sqrt(spread) : 0;
}

TextureBank::TextureBank(Texture texture) : texture_{std::move(texture)}, tables_(steps * steps) {
    for (int y = 0; y < texture_.height(); y += side)
        for (int x = 0; x < texture_.width(); x += side)
            blocks_.push_back(
                {x, y, std::min(side, texture_.width() - x), std::min(side, texture_.height() - y)});
    values_ = std::make_unique_for_overwrite<float[]>(tables_.size() * texels * blocks_.size());
    sums_ = std::make_unique_for_overwrite<Sums[]>(tables_.size() * blocks_.size());
    for (std::size_t k = 0; k < tables_.size(); ++k) {
        tables_[k].values = values_.get() + k * texels * blocks_.size();
        tables_[k].sums = sums_.get() + k * blocks_.size();
    }
    use_.resize(blocks_.size());
    sorted_.reserve(blocks_.size());
    texture_.shift({0, 0});
    double sum = 0;
    for (int y = 0; y < texture_.height(); ++y)
        for (int x = 0; x < texture_.width(); ++x) sum += texture_.value(y)[x];
    level_ = static_cast<float>(std::lround(sum / texture_.width() / texture_.height()));
}

TextureBank::Place TextureBank::nearest(Point shift) noexcept {
    return {static_cast<int>(std::lround(steps * shift.x)), static_cast<int>(std::lround(steps * shift.y))};
}

TextureBank::Table& TextureBank::table_at(Place place) {
    const int x = place.x & (steps - 1), y = place.y & (steps - 1);
    Table& table = tables_[static_cast<std::size_t>(steps * y + x)];
    if (!table.known) learn(table, Place{x, y}.shift());
    return table;
}

void TextureBank::learn(Table& table, Point shift) {
    texture_.shift(shift);
    table.known = true;
    Eigen::Matrix<double, side * side, 6> pixels;
    std::fill_n(table.values, texels * blocks_.size(), 0.0f);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        const Block& block = blocks_[b];
        pixels.setZero();
        for (int j = 0; j < block.rows; ++j) {
            float* const to = table.values + texels * b + 3 * side * j;
            for (int i = 0; i < block.columns; ++i) {
                const int x = block.x + i, y = block.y + j;
                const double t = texture_.value(y)[x] - static_cast<double>(level_),
                             px = texture_.smooth_dx(y)[x], py = texture_.smooth_dy(y)[x];
                pixels.row(side * j + i) << 1, t, texture_.dx(y)[x], texture_.dy(y)[x], px, py;
                to[i] = static_cast<float>(t);
                to[side + i] = static_cast<float>(px);
                to[2 * side + i] = static_cast<float>(py);
            }
        }
        table.sums[b].own = pixels.transpose().lazyProduct(pixels);
    }
}

void TextureBank::learn(Axis axis) {
    for (int along = 0; along < steps; ++along)
        for (int across = -1; across <= 1; ++across)
            table_at(axis == Axis::x ? Place{along, across} : Place{across, along});
}

bool TextureBank::compare(const ImageView& image, Place place, int every) {
    const auto whole_px = [](int n) { return (n - (n & (steps - 1))) / steps; };
    const int x0 = texture_.box().x0 + whole_px(place.x), y0 = texture_.box().y0 + whole_px(place.y);
    now_ = &table_at(place);
    bool any = false;
    for (Use& u : use_) u.compared = false;
    with_pixels(image, [&](auto pixels) {
        for (std::size_t b = 0; b < blocks_.size(); b += static_cast<std::size_t>(every)) {
            const Block& block = blocks_[b];
            const int x = x0 + block.x, y = y0 + block.y;
            if (x < 0 || y < 0 || x + block.columns > image.width || y + block.rows > image.height) continue;
            use_[b].compared = any = true;
            // Pixels that are missing in a row count as the level, and the table is zero there.
            Eight level{};
            for (int i = 0; i < block.columns; ++i) level[i] = level_;
            Eight one{}, t{}, px{}, py{}, own{};
            const float* at = now_->values + texels * b;
            for (int j = 0; j < block.rows; ++j, at += 3 * side) {
                Eight v, texture, slope_x, slope_y;
                take(pixels.row(y + j) + x, block.columns, v);
                take(at, side, texture);
                take(at + side, side, slope_x);
                take(at + 2 * side, side, slope_y);
                v -= level;
                one += v;
                t += v * texture;
                px += v * slope_x;
                py += v * slope_y;
                own += v * v;
            }
            now_->sums[b].picture << sum_of(one), sum_of(t), sum_of(px), sum_of(py), sum_of(own);
        }
    });
    return any;
}

TextureBank::Sums TextureBank::sums() const noexcept {
    Sums all{.own = Eigen::Matrix<double, 6, 6>::Zero(), .picture = Eigen::Matrix<double, 5, 1>::Zero()};
    for (std::size_t b = 0; b < blocks_.size(); ++b)
        if (use_[b].compared && use_[b].used) {
            all.own += now_->sums[b].own;
            all.picture += now_->sums[b].picture;
        }
    return all;
}

void TextureBank::use_all() noexcept {
    for (Use& u : use_) u.used = true;
}

double TextureBank::weigh(double gain, double offset) noexcept {
    sorted_.clear();
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        if (!use_[b].compared) continue;
        const Sums& s = now_->sums[b];
        const Eigen::Vector2d model{offset, gain};
        const double squares =
            s.picture[4] + model.dot(s.own.topLeftCorner<2, 2>() * model - 2 * s.picture.head<2>());
        use_[b].misfit = std::max(0.0, squares) / s.own(0, 0);
        sorted_.push_back(use_[b].misfit);
    }
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.end());
    double kept = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        use_[b].used = use_[b].compared && use_[b].misfit <= misfit_of_half * *middle + rounding_squared;
        if (use_[b].used) kept += now_->sums[b].own(0, 0);
    }
    return kept / (1.0 * texture_.width() * texture_.height());
}

Point TextureBank::climb(const ImageView& image, Point start, int step, int every) {
    use_all();
    const auto likeness = [&](Place place) { return compare(image, place, every) ? sums().likeness() : 0; };
    Place best{steps * static_cast<int>(std::lround(start.x)),
               steps * static_cast<int>(std::lround(start.y))};
    double most = likeness(best);
    for (; step > 0; step /= 2) {
        bool moved = true;
        for (int moves = 0; moved && moves < most_moves; ++moves) {
            moved = false;
            const Place from = best;
            for (int j = -steps * step; j <= steps * step; j += steps * step) {
                for (int i = -steps * step; i <= steps * step; i += steps * step) {
                    if (i == 0 && j == 0) continue;
                    const Place place{from.x + i, from.y + j};
                    const double here = likeness(place);
                    if (here > most) most = here, best = place, moved = true;
                }
            }
        }
    }
    return best.shift();
}

}  // namespace shaker::tracking
