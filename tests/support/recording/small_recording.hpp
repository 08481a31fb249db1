#pragma once
// A small recording with all kinds of data, and functions that read all of them.
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <vector>

#include "drivers/recorded/pictures/picture_store.hpp"
#include "drivers/recorded/recording_file.hpp"
#include "tests/support/recording/recording_folder.hpp"

namespace shaker::test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Session {
    recorded::RecordingHeader header;
    std::vector<PlayTime> played;
    std::vector<DriveChange> changes;
    std::vector<AccelBlock> blocks;
    std::vector<std::vector<FramePtr>> frames;  // one a view
    std::vector<recorded::Column> walker;       // "tracks/top/walker", in alphabetical order
    double v_D = 0;                             // "results/v_D"
    std::string note;                           // "process/note"
};

inline recorded::RecordingHeader small_header() {
    recorded::RecordingHeader h;
    h.title = "Läufer 2 µm, φ = 90°, мю";
    h.kind = "run";
    h.config = "frequency = \"25Hz\"\n# größer als nötig\n";
    h.frequency_hz = 25;
    h.dac = {"dac 日本", 48000, 0.7};
    h.accelerometer = {.name = "ADXL355",
                       .rate_hz = 4000.1,
                       .offset_counts = {0.5, -7, 0},
                       .mps2_per_count = {3.9e-6 * 9.8, 1e-5, 4e-5},
                       .first_sample_s = -0.0123,
                       .clock_uncertainty_s = 0.02,
                       .shaker_axis = {0.6, 0, -0.8}};
    View top{.camera = "top",
             .mm_per_px = 0.11,
             .distance_mm = 500,
             .along = {0.6, 0.8},
             .frame_rate_hz = 100,
             .exposure_s = 1e-3,
             .dac_triggered = true,
             .trigger_delay_s = 2e-6,
             .targets = {}};
    top.targets.push_back({"walker", TargetKind::bars, 0, 12, 2.5, {-3, 4, 50, 60}, 7.5, Polarity::dark});
    top.targets.push_back({"base", TargetKind::disc, 9, 0, 0, {1, 2, 3, 4}, 0, Polarity::bright});
    h.views = {top, View{.camera = "side",
                         .mm_per_px = 0.2,
                         .frame_rate_hz = 50,
                         .exposure_s = 2e-3,
                         .arrival_delay_s = 3e-4,
                         .targets = {}}};
    h.pictures = recorded::KeptPictures::full;
    h.started = "2026-11-22T03:14:15+01:00";
    h.user = "Zoë";
    h.groups = {{"tracks/top/walker",
                 "NXdata",
                 {{"signal", "x"}, {"axes", "t"}},
                 {{"t", "s"}, {"x", "m"}, {"x_errors", "m"}},
                 100},
                {"results", "NXcollection", {}, {{"v_D", "m/s", recorded::Place::Kind::number}}},
                {"process", "NXprocess", {}, {{"note", "", recorded::Place::Kind::text, 40}}}};
    return h;
}

inline FramePtr small_frame(int picture, int width, int height, unsigned bits) {
    Frame f;
    f.tick = {std::int64_t{3} * picture};
    f.arrived = HostTime{std::chrono::nanoseconds{1'000'000'007LL * picture}};
    if (picture != 2) f.stamp = CameraStamp{10'000'000LL * picture - 3};
    if (picture != 1) f.mid_exposure = master_time(0.01 * picture + 1e-17);
    f.quality = picture == 2 ? Quality::gap | Quality::late : Quality::good;
    f.width = width;
    f.height = height;
    f.bytes_per_pixel = bits > 8 ? 2 : 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const unsigned g = grey(picture, x, y, bits);
            f.pixels.push_back(static_cast<std::byte>(g & 0xFFU));
            if (bits > 8) f.pixels.push_back(static_cast<std::byte>(g >> 8U));
        }
    return std::make_shared<Frame>(std::move(f));
}

inline std::vector<AccelBlock> small_blocks() {
    std::vector<AccelBlock> blocks;
    for (int b = 0; b < 4; ++b) {
        AccelBlock block{.first = {std::int64_t{64} * b + (b == 3 ? 1000 : 0)},
                         .arrived = HostTime{std::chrono::nanoseconds{16'000'000LL * b - 5}},
                         .quality = b == 3 ? Quality::gap | Quality::clipped : Quality::good,
                         .size = b == 3 ? 17 : 64};
        for (int i = 0; i < block.size; ++i)
            block.counts[static_cast<std::size_t>(i)] = {1000 * b + i, -i,
                                                         i == 0 ? INT32_MIN : INT32_MAX - i};
        blocks.push_back(block);
    }
    return blocks;
}

inline Session small_session() {
    Session s;
    s.header = small_header();
    s.blocks = small_blocks();
    for (std::int64_t i = 0; i < 5; ++i)
        s.played.push_back(
            {{256 * i}, HostTime{std::chrono::nanoseconds{5'333'333 * i - 7}}, i % 3 == 2 ? 77 * i : 0});
    for (int i = 0; i < 3; ++i) {
        DriveChange c;
        for (int q = 1; q <= max_harmonics; ++q) c.command.volts.at(q) = std::polar(0.1 / q, 0.3 * q + i);
        c.command.frequency = 25 + std::numbers::pi * i;
        c.command.ramp_periods = 1 + i;
        c.command.sequence = UINT64_MAX - static_cast<std::uint64_t>(i);
        c.first = {(std::int64_t{1} << 40) + std::int64_t{1920} * i};
        c.ramp = std::int64_t{1920} * (1 + i);
        c.stop = i == 2 ? 2400 : 0;
        c.phase = turns_of(3, UINT64_MAX - 5) * static_cast<unsigned>(i);
        c.step = turns_per_sample(c.command.frequency, 48000);
        s.changes.push_back(c);
    }
    s.frames.resize(2);
    for (int p = 0; p < 3; ++p) s.frames[0].push_back(small_frame(p, 11, 7, 8));
    for (int p = 0; p < 2; ++p) s.frames[1].push_back(small_frame(p, 6, 5, 16));
    s.walker = {{"t", "s", {0, 0.01, 0.02}},
                {"x", "m", {1e-3, nan, -0.0}},
                {"x_errors", "m", {nan, INFINITY, 1e-320}}};
    s.v_D = -1.0 / 3;
    s.note = "naïve – Ω";
    return s;
}

inline void write_session(const Session& s, const std::filesystem::path& file) {
    std::filesystem::remove(file);
    recorded::RecordingWriter writer{file, s.header};
    std::filesystem::remove_all(recorded::pictures_folder(file));
    for (const PlayTime& p : s.played) writer.add(p);
    for (const DriveChange& c : s.changes) writer.add(c);
    for (const AccelBlock& b : s.blocks) writer.add(b);
    for (std::size_t k = 0; k < s.frames.size(); ++k) {
        pictures::PictureStore store{recorded::pictures_folder(file), s.header.views[k].camera, 64};
        const bool kept = s.header.pictures != recorded::KeptPictures::off;
        for (const FramePtr& f : s.frames[k]) writer.add(k, *f, kept ? store.add(*f) : 0);
        if (kept) store.finish();
    }
    writer.flush();
    writer.rows("tracks/top/walker", s.walker);
    writer.scalar("results/v_D", s.v_D);
    writer.text("process/note", s.note);
    writer.close();
}

/// Everything that can be read from such a recording.
inline Session read_session(const std::filesystem::path& file) {
    const recorded::RecordingReader reader{file};
    Session s;
    s.header = reader.header();
    s.played = reader.play_times();
    s.changes = reader.changes();
    Rig rig = recorded::replay_rig(reader, reader.header(), reader.frames_without_picture() == 0);
    AccelBlock block;
    while (rig.accelerometer && rig.accelerometer->read(block, no_wait)) s.blocks.push_back(block);
    for (const auto& camera : rig.cameras) s.frames.push_back(all_frames(*camera));
    for (const std::string& camera : reader.names("tracks")) {
        const std::filesystem::path group = std::filesystem::path{"tracks"} / camera;
        for (const std::string& target : reader.names(group)) s.walker = reader.table(group / target);
    }
    s.v_D = reader.scalar("results/v_D");
    s.note = reader.text("process/note");
    return s;
}

inline std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{in}, {}};
}

}  // namespace shaker::test
