#include "drivers/simulated/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace shaker::simulated {

namespace {
constexpr float ground = 0.15F, strip = 0.85F, mark = 0.10F, disc = 0.80F, backlight = 0.80F, shadow = 0.12F;
constexpr double full_scale_dn = 230;
constexpr int table_per_px = 512;
constexpr double edge_reach_px = 6;
constexpr std::size_t noise_size = 1U << 16;
constexpr double mark_mm = 2.6, mark_pitch_mm = 8;

const Target& target_named(const CameraTruth& camera, const char* name) {
    return *std::ranges::find(camera.view.targets, name, &Target::name);
}

double px_per_m(const View& view, double offset_mm) {
    const double shrink = view.distance_mm > 0 ? 1 - offset_mm / view.distance_mm : 1;
    return 1e3 / (view.mm_per_px * shrink);
}
}  // namespace

PictureLayout layout_of(const CameraTruth& camera, const WalkerTruth& walker) {
    PictureLayout l{};
    l.centre_x = 0.5 * (camera.width - 1);
    l.base_px_per_m = px_per_m(camera.view, target_named(camera, "base").offset_mm);
    l.walker_px_per_m = px_per_m(camera.view, target_named(camera, "walker").offset_mm);
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
      layout_{layout_of(camera, walker)},
      seed_{seed},
      light_(static_cast<std::size_t>(camera.width)),
      noise_(noise_size),
      scene_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)),
      profile_(static_cast<std::size_t>(camera.width)) {
    const Target& base = target_named(camera, "base");
    pitch_px_ = 1e-3 * (base.pitch_mm > 0 ? base.pitch_mm : mark_pitch_mm) * layout_.base_px_per_m;
    mark_px_ = camera.side
                   ? 0.5 * pitch_px_
                   : 1e-3 * (base.diameter_mm > 0 ? base.diameter_mm : mark_mm) * layout_.base_px_per_m;
    for (std::size_t x = 0; x < light_.size(); ++x) {
        const double u = 2.0 * static_cast<double>(x) / static_cast<double>(camera.width) - 1;
        light_[x] = static_cast<float>(full_scale_dn * (1 - camera.light_gradient * (0.5 - 0.5 * u)));
    }
    const double sigma = std::sqrt(camera.psf_px * camera.psf_px + 1.0 / 12);  // of lens and pixel
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

void Renderer::draw_marks(double shift_px, float weight) {
    const int top = static_cast<int>(std::ceil(layout_.marks_top));
    const int bottom = static_cast<int>(layout_.marks_bottom);
    const double middle = 0.5 * (layout_.marks_top + layout_.marks_bottom);
    const double origin = layout_.centre_x + shift_px;
    for (int y = top; y < bottom; ++y) {
        // Dots differ from row to row; all rows of bars are equal.
        if (y == top || !camera_.side) {
            for (int x = 0; x < camera_.width; ++x) {
                const double away = x - origin;  // truncation of a positive number removes whole pitches
                const double along = away - pitch_px_ * (static_cast<int>(away / pitch_px_ + 4096.5) - 4096);
                const double r = camera_.side ? std::abs(along) : std::hypot(along, y - middle);
                profile_[static_cast<std::size_t>(x)] =
                    weight * (strip + (mark - strip) * edge(0.5 * mark_px_ - r));
            }
        }
        float* row = &scene_[static_cast<std::size_t>(y) * light_.size()];
        for (int x = 0; x < camera_.width; ++x)
            row[x] += profile_[static_cast<std::size_t>(x)] - weight * row_ground();
    }
}

void Renderer::draw_disc(double centre_px, float weight) {
    const double radius = layout_.walker_half_width;
    const int y0 = std::max(0, static_cast<int>(layout_.walker_y - radius - edge_reach_px));
    const int y1 = std::min(camera_.height - 1, static_cast<int>(layout_.walker_y + radius + edge_reach_px));
    for (int y = y0; y <= y1; ++y) {
        const double dy = y - layout_.walker_y;
        const double reach = (radius + edge_reach_px) * (radius + edge_reach_px) - dy * dy;
        if (reach <= 0) continue;
        const int x0 = std::max(0, static_cast<int>(centre_px - std::sqrt(reach)));
        const int x1 = std::min(camera_.width - 1, static_cast<int>(centre_px + std::sqrt(reach)));
        const double inner = (radius - edge_reach_px) * (radius - edge_reach_px) - dy * dy;
        const double solid = radius > edge_reach_px && inner > 0 ? std::sqrt(inner) : -1;
        float* row = &scene_[static_cast<std::size_t>(y) * light_.size()];
        for (int x = x0; x <= x1; ++x) {
            const double dx = x - centre_px;
            const float cover = std::abs(dx) < solid ? 1.0F : edge(radius - std::hypot(dx, dy));
            row[x] += weight * cover * (disc - ground);
        }
    }
}

void Renderer::draw_silhouette(double centre_px, float weight) {
    const int y0 =
        std::max(0, static_cast<int>(layout_.walker_y - layout_.walker_half_height - edge_reach_px));
    const int y1 = std::min(camera_.height - 1, static_cast<int>(layout_.marks_top) - 1);
    const double reach = layout_.walker_half_width + edge_reach_px;
    const int x0 = std::max(0, static_cast<int>(centre_px - reach));
    const int x1 = std::min(camera_.width - 1, static_cast<int>(centre_px + reach));
    for (int x = x0; x <= x1; ++x)
        profile_[static_cast<std::size_t>(x)] = edge(layout_.walker_half_width - std::abs(x - centre_px));
    for (int y = y0; y <= y1; ++y) {
        const float high =
            weight * edge(y - (layout_.walker_y - layout_.walker_half_height)) * (shadow - backlight);
        float* row = &scene_[static_cast<std::size_t>(y) * light_.size()];
        for (int x = x0; x <= x1; ++x) row[x] += high * profile_[static_cast<std::size_t>(x)];
    }
}

float Renderer::row_ground() const noexcept { return camera_.side ? backlight : ground; }

void Renderer::draw(const Pose& pose, float weight, bool walker) {
    const double along = camera_.view.along[0];
    draw_marks(along * pose.base * layout_.base_px_per_m, weight);
    if (!walker) return;
    const double centre = layout_.centre_x + along * pose.walker * layout_.walker_px_per_m;
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
        for (std::size_t x = 0; x < width; ++x) {
            const float dn = scene_[y * width + x] * light_[x] + noise_[start + x];
            const float whole = std::clamp(dn + 0.5F, 0.0F, 255.0F);
            pixels[y * width + x] = static_cast<std::byte>(static_cast<int>(whole));
        }
    }
}

}  // namespace shaker::simulated
