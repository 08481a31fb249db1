#include "daemon/remote/web/live_frames.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"

namespace shaker::web {

static_assert(std::endian::native == std::endian::little, "frames are little-endian");

namespace {

constexpr std::uint16_t version = 1;
constexpr std::uint16_t gap_before = 1, min_max_pairs = 2, fewer_than_there_were = 4;
constexpr int widest_picture = 640, jpeg_quality = 70;

template <class T>
void put(std::string& out, T value) {
    std::array<char, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof(T));
    out.append(bytes.data(), bytes.size());
}

std::string header(StreamId id, std::uint64_t first, double t0_s, double dt_s, std::size_t n,
                   std::size_t channels, unsigned flags) {
    std::string out;
    put(out, frame_magic);
    put(out, version);
    put(out, static_cast<std::uint16_t>(id));
    put(out, first);
    put(out, t0_s);
    put(out, dt_s);
    put(out, static_cast<std::uint32_t>(n));
    put(out, static_cast<std::uint16_t>(channels));
    put(out, static_cast<std::uint16_t>(flags));
    return out;
}

std::vector<float> floats(const std::vector<double>& values) { return {values.begin(), values.end()}; }

struct Mark {
    std::array<float, 4> box;  // x, y, w, h, px
    std::uint8_t kind;
};

// Without a JPEG library the page works without pictures.
std::vector<unsigned char> jpeg_or_nothing(const cv::Mat& grey) {
    try {
        return codecs::jpeg_of(grey, jpeg_quality);
    } catch (const DeviceError& missing) {
        static std::once_flag reported;
        std::call_once(reported, [&] { spdlog::warn("no pictures for the page: {}", missing.what()); });
        return {};
    }
}

// Half-size of a target as seen from its centre: a dot has its own size, a walker that of its outline.
Mark mark_of(const tracking::Fix& fix, const Target& target, double px_per_mm, float scale) {
    const double extent = std::max({target.diameter_mm, target.width_mm, 1.0}) * px_per_mm;
    const auto size = static_cast<float>(extent) * scale;
    const unsigned kind = target.name == "walker" ? 0 : 1;
    const auto quality = static_cast<unsigned>(fix.state);
    return {{static_cast<float>(fix.x_px) * scale - size / 2, static_cast<float>(fix.y_px) * scale - size / 2,
             size, size},
            static_cast<std::uint8_t>(kind | quality << 4U)};
}

}  // namespace

std::string frame_of(const Samples& s) {
    const std::size_t n = s.channels.empty() ? 0 : s.channels.front().size();
    const unsigned flags = (s.gap ? gap_before : 0U) | (s.pairs ? min_max_pairs : 0U) |
                           (s.decimated ? fewer_than_there_were : 0U);
    std::string out = header(s.id, s.first, s.t0_s, s.dt_s, n, s.channels.size(), flags);
    for (std::size_t i = 0; i < n; ++i)
        for (const std::vector<float>& channel : s.channels) put(out, channel[i]);
    return out;
}

Samples decimated(const service::LiveSeries::Part& part, std::size_t channels, std::size_t width,
                  StreamId id) {
    Samples out{.id = id,
                .first = part.first,
                .channels = std::vector<std::vector<float>>(channels),
                .gap = part.gap};
    const std::size_t n = part.t_s.size();
    if (n == 0) return out;
    const std::size_t columns = std::max<std::size_t>(1, width);
    const std::size_t each = n > 2 * columns ? (n + columns - 1) / columns : 1;
    out.t0_s = part.t_s.front();
    const double step_s = n > 1 ? (part.t_s.back() - part.t_s.front()) / static_cast<double>(n - 1) : 0;
    out.decimated = out.pairs = each > 1;
    out.dt_s = each > 1 ? step_s * static_cast<double>(each) / 2 : step_s;
    for (std::size_t from = 0; from < n; from += each) {
        const std::size_t to = std::min(n, from + each);
        for (std::size_t c = 0; c < channels; ++c) {
            const auto value = [&](std::size_t i) { return part.values[i * channels + c]; };
            std::size_t low = from, high = from;
            for (std::size_t i = from; i < to; ++i) {
                if (value(i) < value(low)) low = i;
                if (value(i) > value(high)) high = i;
            }
            out.channels[c].push_back(value(std::min(low, high)));
            if (each > 1) out.channels[c].push_back(value(std::max(low, high)));
        }
    }
    return out;
}

Samples waveform_of(const service::WaveformState& w) {
    const double n = static_cast<double>(std::max<std::size_t>(1, w.asked.size()));
    return {.id = StreamId::waveform,
            .t0_s = w.t_s,
            .dt_s = 2 * w.period_s / n,
            .channels = {w.asked, w.measured}};
}

Samples cycle_of(const reduction::Reduction& r) {
    const reduction::Cycle& c = r.cycle;
    const double n = static_cast<double>(std::max<std::size_t>(1, c.phase.size()));
    return {.id = StreamId::cycle,
            .t0_s = r.t0_s,
            .dt_s = 1 / (r.frequency.value * n),
            .channels = {floats(c.x_m), floats(c.x_sd_m), floats(c.v_mps), floats(c.v_sd_mps),
                         floats(c.v_base_mps)}};
}

void load_encoder() { codecs::load_now(); }

std::string picture_frame(const service::PictureState& p, std::size_t k) {
    if (!p.frame || p.frame->pixels.empty()) return {};
    const Frame& f = *p.frame;
    // OpenCV takes no const pixels; it does not write to them.
    const cv::Mat whole(
        f.height, f.width, f.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1,
        const_cast<std::byte*>(f.pixels.data()));  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    cv::Mat grey;
    whole.convertTo(grey, CV_8U, f.bytes_per_pixel == 2 ? 1.0 / 256 : 1.0);
    const float scale = std::min(1.0F, static_cast<float>(widest_picture) / static_cast<float>(f.width));
    cv::Mat small;
    cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
    const std::vector<unsigned char> jpeg = jpeg_or_nothing(small);
    if (jpeg.empty()) return {};
    std::vector<Mark> marks;
    for (std::size_t i = 0; i < std::min(p.fixes.size(), p.targets.size()); ++i)
        marks.push_back(mark_of(p.fixes[i], p.targets[i], p.px_per_mm, scale));
    const auto id = static_cast<StreamId>(static_cast<std::size_t>(StreamId::first_camera) + k);
    std::string out = header(id, static_cast<std::uint64_t>(std::max<std::int64_t>(0, f.tick.n)), p.t_s, 0,
                             jpeg.size(), 1, 0);
    put(out, static_cast<std::uint16_t>(small.cols));
    put(out, static_cast<std::uint16_t>(small.rows));
    put(out, static_cast<std::uint16_t>(marks.size()));
    put(out, std::uint16_t{0});
    for (const Mark& m : marks)
        for (const float v : m.box) put(out, v);
    for (const Mark& m : marks) put(out, m.kind);
    out.append((4 - marks.size() % 4) % 4, '\0');
    out.append(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());  // NOLINT: bytes are bytes
    return out;
}

}  // namespace shaker::web
