#include "drivers/simulated/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "drivers/optics/bar_code.hpp"
#include "drivers/simulated/true_view.hpp"

namespace shaker::simulated {

namespace {
constexpr float ground = 0.15F, strip = 0.85F, mark = 0.10F, disc = 0.80F, backlight = 0.80F, shadow = 0.12F;
constexpr double full_scale_dn = 230;
constexpr int table_per_px = 512;
constexpr double edge_reach_px = 6;
constexpr double black_and_white = 5.8;  // standard deviations from an edge, where a float shows no grey
constexpr std::size_t noise_size = 1U << 16;
constexpr double mark_mm = 2.6, mark_pitch_mm = 8;

const Target& target_named(const CameraTruth& camera, const char* name) {
    return *std::ranges::find(camera.view.targets, name, &Target::name);
}

// Four pixels at a time.
using Lanes [[gnu::vector_size(16)]] = float;
constexpr std::size_t lanes = 4;

Lanes load(const float* from) noexcept {
    Lanes values;
    std::memcpy(&values, from, sizeof values);
    return values;
}

// row[x] += values[x] - less.
void add(std::span<float> row, const float* values, float less) noexcept {
    std::size_t x = 0;
    for (; x + lanes <= row.size(); x += lanes) {
        const Lanes sum = load(&row[x]) + (load(values + x) - less);
        std::memcpy(&row[x], &sum, sizeof sum);
    }
    for (; x < row.size(); ++x) row[x] += values[x] - less;
}

// row[x] += strength values[x].
void add_scaled(std::span<float> row, const float* values, float strength) noexcept {
    std::size_t x = 0;
    for (; x + lanes <= row.size(); x += lanes) {
        const Lanes sum = load(&row[x]) + strength * load(values + x);
        std::memcpy(&row[x], &sum, sizeof sum);
    }
    for (; x < row.size(); ++x) row[x] += strength * values[x];
}

// One row as the sensor sees it.
void expose(std::span<const float> scene, const float* light, const float* noise,
            std::byte* pixels) noexcept {
    constexpr float half = 0.5F, most = 255;
    using Whole [[gnu::vector_size(16)]] = std::int32_t;
    using Pairs [[gnu::vector_size(16)]] = std::int16_t;
    using Bytes [[gnu::vector_size(16)]] = std::uint8_t;
    const auto grey = [&](std::size_t x) {
        Lanes dn = load(&scene[x]) * load(light + x) + load(noise + x) + half;
        dn = dn > 0 ? dn : Lanes{};
        dn = dn < most ? dn : Lanes{} + most;
        return reinterpret_cast<Pairs>(__builtin_convertvector(dn, Whole));
    };
    // Keeps the lower half of each number, twice.
    const auto halves = [](auto a, auto b) {
        if constexpr (sizeof a[0] == 2)
            return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14);
        else
            return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    };
    std::size_t x = 0;
    for (; x + 4 * lanes <= scene.size(); x += 4 * lanes) {
        const auto low = reinterpret_cast<Bytes>(halves(grey(x), grey(x + lanes)));
        const auto high = reinterpret_cast<Bytes>(halves(grey(x + 2 * lanes), grey(x + 3 * lanes)));
        const Bytes all = halves(low, high);
        std::memcpy(pixels + x, &all, sizeof all);
    }
    for (; x < scene.size(); ++x) {
        const float dn = std::clamp(scene[x] * light[x] + noise[x] + half, 0.0F, most);
        pixels[x] = static_cast<std::byte>(static_cast<int>(dn));
    }
}

double px_per_m(const View& view, double offset_mm) { return 1e3 / optics::mm_per_px_at(view, offset_mm); }
}  // namespace

PictureLayout layout_of(const CameraTruth& camera, const WalkerTruth& walker) {
    PictureLayout l{};
    const View truth = true_view(camera);
    l.centre_x = 0.5 * (camera.width - 1);
    l.base_px_per_m = px_per_m(truth, target_named(camera, "base").offset_mm);
    l.walker_px_per_m = px_per_m(truth, target_named(camera, "walker").offset_mm);
    l.walker_half_width = 0.5e-3 * walker.diameter_mm * l.walker_px_per_m;
    if (camera.side) {
        l.marks_top = 0.68 * camera.height;
        l.marks_bottom = camera.height - 2.0;
        l.walker_half_height = 0.5e-3 * walker.height_mm * l.walker_px_per_m;
        l.walker_y = l.marks_top - l.walker_half_height;
    } else {
        l.marks_top = 1;
        l.marks_bottom = 1 + 0.15 * camera.height;
        l.walker_half_height = l.walker_half_width;
        l.walker_y = 0.5 * (l.marks_bottom + camera.height);
    }
    return l;
}

Renderer::Renderer(const CameraTruth& camera, const WalkerTruth& walker, std::uint64_t seed)
    : camera_{camera},
      truth_{true_view(camera)},
      layout_{layout_of(camera, walker)},
      seed_{seed},
      light_(static_cast<std::size_t>(camera.width)),
      noise_(noise_size),
      scene_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)),
      profile_(static_cast<std::size_t>(camera.width)),
      along_(static_cast<std::size_t>(camera.width)) {
    const Target& base = target_named(camera, "base");
    pitch_px_ = 1e-3 * (base.pitch_mm > 0 ? base.pitch_mm : mark_pitch_mm) * layout_.base_px_per_m;
    mark_px_ = camera.side
                   ? 0.5 * pitch_px_
                   : 1e-3 * (base.diameter_mm > 0 ? base.diameter_mm : mark_mm) * layout_.base_px_per_m;
    if (camera.code_seed > 0) {
        const optics::BarCode code{.seed = static_cast<std::uint64_t>(camera.code_seed), .length_mm = 1000};
        for (const double edge : optics::edges_of(code))
            code_px_.push_back(1e-3 * (edge - 0.5 * code.length_mm) * layout_.base_px_per_m);
    }
    const double row = 0.5 * (layout_.marks_top + layout_.marks_bottom);
    const double zero = optics::place_at(truth_, base.offset_mm, {layout_.centre_x, row})[0];
    for (int x = 0; x < camera.width; ++x) {
        columns_.push_back(x);
        if (truth_.lens.focal_px <= 0) continue;
        const double mm = optics::place_at(truth_, base.offset_mm, {columns_.back(), row})[0] - zero;
        columns_.back() = layout_.centre_x + camera.view.along[0] * 1e-3 * mm * layout_.base_px_per_m;
    }
    for (std::size_t x = 0; x < light_.size(); ++x) {
        const double u = 2.0 * static_cast<double>(x) / static_cast<double>(camera.width) - 1;
        light_[x] = static_cast<float>(full_scale_dn * (1 - camera.light_gradient * (0.5 - 0.5 * u)));
    }
    const double sigma = std::sqrt(camera.psf_px * camera.psf_px + 1.0 / 12);  // of lens and pixel
    wide_ = std::min(edge_reach_px, black_and_white * sigma);
    const int half = static_cast<int>(edge_reach_px * table_per_px);
    for (int i = -half; i <= half; ++i)
        erf_.push_back(static_cast<float>(0.5 + 0.5 * std::erf(i / (table_per_px * sigma * std::sqrt(2.0)))));
    std::mt19937_64 rng{seed};
    std::normal_distribution<double> gauss{0, camera.noise_dn};
    for (float& n : noise_) n = static_cast<float>(gauss(rng));
}

// Share of light at `distance_px` inside an edge; interpolated linearly from a table.
float Renderer::edge(double distance_px) const noexcept {
    const double u = (std::clamp(distance_px, -edge_reach_px, edge_reach_px) + edge_reach_px) * table_per_px;
    const auto i = std::min(static_cast<std::size_t>(u), erf_.size() - 2);
    const auto f = static_cast<float>(u - static_cast<double>(i));
    return erf_[i] + f * (erf_[i + 1] - erf_[i]);
}

// All rows are equal. Every second edge ends a dark bar.
void Renderer::draw_code(double shift_px, float weight) {
    for (std::size_t x = 0; x < profile_.size(); ++x) {
        const double at = camera_.view.along[0] * (columns_[x] - layout_.centre_x - shift_px);
        auto edge_at = std::ranges::lower_bound(code_px_, at - wide_);
        auto sign = (edge_at - code_px_.begin()) % 2 == 0 ? 1.0F : -1.0F;
        float cover = sign > 0 ? 0 : 1;
        for (; edge_at != code_px_.end() && *edge_at < at + wide_; ++edge_at, sign = -sign)
            cover += sign * edge(at - *edge_at);
        profile_[x] = weight * (strip + (mark - strip) * cover);
    }
    const int bottom = static_cast<int>(layout_.marks_bottom);
    for (int y = static_cast<int>(std::ceil(layout_.marks_top)); y < bottom; ++y)
        add(row_of(y, 0, camera_.width - 1), profile_.data(), weight * row_ground());
}

void Renderer::draw_marks(double shift_px, float weight) {
    if (!code_px_.empty()) return draw_code(shift_px, weight);
    const int top = static_cast<int>(std::ceil(layout_.marks_top));
    const int bottom = static_cast<int>(layout_.marks_bottom);
    const double middle = 0.5 * (layout_.marks_top + layout_.marks_bottom);
    const double origin = layout_.centre_x + shift_px;
    const double half = 0.5 * mark_px_, reach = half + wide_;
    for (int x = 0; x < camera_.width; ++x) {
        const double away = columns_[static_cast<std::size_t>(x)] -
                            origin;  // truncation of a positive number removes whole pitches
        along_[static_cast<std::size_t>(x)] =
            away - pitch_px_ * (static_cast<int>(away / pitch_px_ + 4096.5) - 4096);
    }
    for (int y = top; y < bottom; ++y) {
        // Dots differ from row to row; all rows of bars are equal.
        if (y == top || !camera_.side) {
            const double dy = camera_.side ? 0 : y - middle;
            for (std::size_t x = 0; x < along_.size(); ++x) {
                const double squared = along_[x] * along_[x] + dy * dy;
                const float cover = squared < reach * reach ? edge(half - std::sqrt(squared)) : 0;
                profile_[x] = weight * (strip + (mark - strip) * cover);
            }
        }
        add(row_of(y, 0, camera_.width - 1), profile_.data(), weight * row_ground());
    }
}

void Renderer::draw_disc(double centre_px, float weight) {
    const double radius = layout_.walker_half_width;
    const int y0 = std::max(0, static_cast<int>(layout_.walker_y - radius - wide_));
    const int y1 = std::min(camera_.height - 1, static_cast<int>(layout_.walker_y + radius + wide_));
    for (int y = y0; y <= y1; ++y) {
        const double dy = y - layout_.walker_y;
        const double reach = (radius + wide_) * (radius + wide_) - dy * dy;
        if (reach <= 0) continue;
        const int x0 = std::max(0, static_cast<int>(centre_px - std::sqrt(reach)));
        const int x1 = std::min(camera_.width - 1, static_cast<int>(centre_px + std::sqrt(reach)));
        const double inner = (radius - wide_) * (radius - wide_) - dy * dy;
        const double solid = radius > wide_ && inner > 0 ? std::sqrt(inner) : -1;
        const std::span<float> row = row_of(y, 0, camera_.width - 1);
        const auto draw = [&](int from, int to) {
            for (int x = from; x < to; ++x) {
                const double dx = x - centre_px;
                const float cover = edge(radius - std::sqrt(dx * dx + dy * dy));
                row[static_cast<std::size_t>(x)] += weight * cover * (disc - ground);
            }
        };
        const int first = std::clamp(static_cast<int>(std::ceil(centre_px - solid)), x0, x1 + 1);
        const int last = std::clamp(static_cast<int>(std::floor(centre_px + solid)) + 1, first, x1 + 1);
        draw(x0, first);
        for (int x = first; x < last; ++x) row[static_cast<std::size_t>(x)] += weight * (disc - ground);
        draw(last, x1 + 1);
    }
}

void Renderer::draw_silhouette(double centre_px, float weight) {
    const int y0 = std::max(0, static_cast<int>(layout_.walker_y - layout_.walker_half_height - wide_));
    const int y1 = std::min(camera_.height - 1, static_cast<int>(layout_.marks_top) - 1);
    const double reach = layout_.walker_half_width + wide_;
    const int x0 = std::max(0, static_cast<int>(centre_px - reach));
    const int x1 = std::min(camera_.width - 1, static_cast<int>(centre_px + reach));
    for (int x = x0; x <= x1; ++x)
        profile_[static_cast<std::size_t>(x)] = edge(layout_.walker_half_width - std::abs(x - centre_px));
    for (int y = y0; y <= y1 && x0 <= x1; ++y) {
        const float high =
            weight * edge(y - (layout_.walker_y - layout_.walker_half_height)) * (shadow - backlight);
        add_scaled(row_of(y, x0, x1), &profile_[static_cast<std::size_t>(x0)], high);
    }
}

std::span<float> Renderer::row_of(int y, int x0, int x1) noexcept {
    return {&scene_[static_cast<std::size_t>(y) * light_.size() + static_cast<std::size_t>(x0)],
            static_cast<std::size_t>(x1 - x0 + 1)};
}

float Renderer::row_ground() const noexcept { return camera_.side ? backlight : ground; }

void Renderer::draw(const Pose& pose, float weight, bool walker) {
    const double along = camera_.view.along[0];
    draw_marks(along * pose.base * layout_.base_px_per_m, weight);
    if (!walker) return;
    const double centre = seen_at(truth_, target_named(camera_, "walker").offset_mm, pose.walker,
                                  layout_.centre_x, layout_.walker_y, layout_.walker_px_per_m)[0];
    if (camera_.side)
        draw_silhouette(centre, weight);
    else
        draw_disc(centre, weight);
}

// Less blur than this widens an edge by less than 1e-4 of its width: one picture at the mean pose is enough.
bool Renderer::moves(std::span<const Pose> poses) const noexcept {
    constexpr double still_px = 0.05;
    const auto [b0, b1] = std::ranges::minmax(poses, {}, &Pose::base);
    const auto [w0, w1] = std::ranges::minmax(poses, {}, &Pose::walker);
    return (b1.base - b0.base) * layout_.base_px_per_m > still_px ||
           (w1.walker - w0.walker) * layout_.walker_px_per_m > still_px;
}

void Renderer::render(std::span<const Pose> poses, CameraTick tick, std::span<std::byte> pixels,
                      bool walker) {
    std::ranges::fill(scene_, row_ground());
    const auto share = 1.0 / static_cast<double>(poses.size());
    Pose mean;
    for (const Pose& pose : poses) {
        mean.base += share * pose.base;
        mean.walker += share * pose.walker;
    }
    if (moves(poses)) {
        for (const Pose& pose : poses) draw(pose, static_cast<float>(share), walker);
    } else {
        draw(mean, 1, walker);
    }
    const auto width = static_cast<std::size_t>(camera_.width);
    std::mt19937_64 rng{seed_ ^ (0x9E3779B97F4A7C15U * static_cast<std::uint64_t>(tick.n + 1))};
    for (std::size_t y = 0; y < static_cast<std::size_t>(camera_.height); ++y) {
        const std::size_t start = static_cast<std::size_t>(rng()) % (noise_size - width);
        expose({&scene_[y * width], width}, light_.data(), &noise_[start], &pixels[y * width]);
    }
}

}  // namespace shaker::simulated
