#include "tracking/image/texture_bank.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace shaker::tracking {

namespace {

struct Taps {
    std::array<double, 4> value{}, slope{};
};

// Weights of coefficients n - 1 .. n + 2 for the spline at n + f.
Taps taps(double f) noexcept {
    const double g = 1 - f;
    return {{g * g * g / 6, 2.0 / 3 - 0.5 * f * f * (2 - f), 2.0 / 3 - 0.5 * g * g * (2 - g), f * f * f / 6},
            {-0.5 * g * g, f * (1.5 * f - 2), -g * (1.5 * g - 2), 0.5 * f * f}};
}

// Converts samples to coefficients in place (recursive filter of the cubic B-spline, mirrored ends).
void prefilter(double* c, int n, std::ptrdiff_t step) {
    if (n < 2) return;
    const double z = std::sqrt(3.0) - 2;
    const auto at = [&](int i) -> double& { return c[i * step]; };
    double sum = at(0), power = z;
    for (int i = 1; i < std::min(n, 30); ++i, power *= z) sum += power * at(i);
    at(0) = sum;
    for (int i = 1; i < n; ++i) at(i) += z * at(i - 1);
    at(n - 1) = z / (z * z - 1) * (at(n - 1) + z * at(n - 2));
    for (int i = n - 2; i >= 0; --i) at(i) = z * (at(i + 1) - at(i));
    for (int i = 0; i < n; ++i) at(i) *= 6;
}

// Binomial filter of five in place; the two values at each end are unchanged.
void smooth(double* c, int n, std::ptrdiff_t step) {
    if (n < 5) return;
    double a = c[0], b = c[step];
    for (int i = 2; i < n - 2; ++i) {
        double& here = c[i * step];
        const double old = here;
        here = (a + c[(i + 2) * step] + 4 * (b + c[(i + 1) * step]) + 6 * old) / 16;
        a = b;
        b = old;
    }
}

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

Texture::Texture(const ImageView& image, const Box& box) : box_{box} {
    const int w = width() + 2 * margin, h = height() + 2 * margin;
    coefficients_.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
    const auto mirror = [](int i, int n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
    with_pixels(image, [&](auto pixels) {
        double* out = coefficients_.data();
        for (int y = box.y0 - margin; y < box.y1 + margin; ++y) {
            for (int x = box.x0 - margin; x < box.x1 + margin; ++x) {
                *out++ = pixels.at(mirror(x, image.width), mirror(y, image.height));
            }
        }
    });
    for (int y = 0; y < h; ++y) prefilter(coefficients_.data() + std::ptrdiff_t{y} * w, w, 1);
    for (int x = 0; x < w; ++x) prefilter(coefficients_.data() + x, h, w);
    smooth_ = coefficients_;
    for (int y = 0; y < h; ++y) smooth(smooth_.data() + std::ptrdiff_t{y} * w, w, 1);
    for (int x = 0; x < w; ++x) smooth(smooth_.data() + x, h, w);
    const auto count = static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
    for (auto* v : {&value_, &dx_, &dy_, &smooth_value_, &smooth_dx_, &smooth_dy_}) v->resize(count);
    row_value_.resize(static_cast<std::size_t>(h) * static_cast<std::size_t>(width()));
    row_dx_.resize(row_value_.size());
}

void Texture::shift(Point shift) {
    evaluate(coefficients_, shift, value_.data(), dx_.data(), dy_.data());
    evaluate(smooth_, shift, smooth_value_.data(), smooth_dx_.data(), smooth_dy_.data());
}

void Texture::evaluate(const std::vector<double>& coefficients, Point shift, double* out, double* out_dx,
                       double* out_dy) {
    const int w = width(), wide = w + 2 * margin, tall = height() + 2 * margin;
    const int nx = static_cast<int>(std::floor(-shift.x)), ny = static_cast<int>(std::floor(-shift.y));
    const Taps tx = taps(-shift.x - nx), ty = taps(-shift.y - ny);
    for (int y = 0; y < tall; ++y) {
        const double* c = coefficients.data() + std::ptrdiff_t{y} * wide + margin + nx - 1;
        double* value = row_value_.data() + std::ptrdiff_t{y} * w;
        double* slope = row_dx_.data() + std::ptrdiff_t{y} * w;
        for (int x = 0; x < w; ++x) {
            value[x] =
                tx.value[0] * c[x] + tx.value[1] * c[x + 1] + tx.value[2] * c[x + 2] + tx.value[3] * c[x + 3];
            slope[x] =
                tx.slope[0] * c[x] + tx.slope[1] * c[x + 1] + tx.slope[2] * c[x + 2] + tx.slope[3] * c[x + 3];
        }
    }
    for (int y = 0; y < height(); ++y) {
        const double* v = row_value_.data() + std::ptrdiff_t{y + margin + ny - 1} * w;
        const double* d = row_dx_.data() + std::ptrdiff_t{y + margin + ny - 1} * w;
        for (int x = 0; x < w; ++x) {
            const auto i = at(y) + static_cast<std::size_t>(x);
            const std::array<double, 4> column{v[x], v[x + w], v[x + 2 * w], v[x + 3 * w]};
            out[i] = ty.value[0] * column[0] + ty.value[1] * column[1] + ty.value[2] * column[2] +
                     ty.value[3] * column[3];
            out_dy[i] = ty.slope[0] * column[0] + ty.slope[1] * column[1] + ty.slope[2] * column[2] +
                        ty.slope[3] * column[3];
            out_dx[i] = ty.value[0] * d[x] + ty.value[1] * d[x + w] + ty.value[2] * d[x + 2 * w] +
                        ty.value[3] * d[x + 3 * w];
        }
    }
}

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
