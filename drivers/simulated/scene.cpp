#include "drivers/simulated/scene.hpp"

#include <algorithm>
#include <cmath>
#include <list>

#include "drivers/attitude.hpp"
#include "drivers/settings_table.hpp"
#include "drivers/simulated/renderer.hpp"
#include "drivers/simulated/sensor.hpp"
#include "drivers/simulated/settings_parts.hpp"
#include "drivers/simulated/true_view.hpp"

namespace shaker::simulated {

namespace {

// Regions of the resting scene, slightly larger than the targets, as an operator would draw them.
void place_regions(Scene& scene) {
    for (CameraTruth& c : scene.cameras) {
        const PictureLayout l = layout_of(c, scene.walker);
        for (Target& t : c.view.targets) {
            if (t.name == "base") {
                if (c.code_seed > 0) t.kind = TargetKind::code, t.pitch_mm = t.diameter_mm = 0;
                const int margin = c.width / 10;
                const int top = static_cast<int>(l.marks_top) + (c.side ? 2 : 0);
                t.roi_px = {margin, top, c.width - 2 * margin, static_cast<int>(l.marks_bottom) - top};
                continue;
            }
            (c.side ? t.width_mm : t.diameter_mm) = scene.walker.diameter_mm;
            const double x = l.centre_x + c.view.along[0] * 1e-3 * scene.walker.start_mm * l.walker_px_per_m;
            const double half_w = l.walker_half_width + 8, half_h = l.walker_half_height + (c.side ? -3 : 4);
            const int x0 = std::max(0, static_cast<int>(x - half_w));
            const int y0 = std::max(0, static_cast<int>(l.walker_y - half_h));
            const int x1 = std::min(c.width, static_cast<int>(x + half_w) + 1);
            const int y1 = std::min(c.height, static_cast<int>(l.walker_y + half_h) + 1);
            t.roi_px = {std::max(0, x0 + c.region_off_px), y0, x1 - x0, y1 - y0};
        }
    }
}

CameraTruth camera(const char* name, bool side, int height, double distance_mm) {
    CameraTruth c;
    c.side = side;
    c.width = 320;
    c.height = height;
    c.view.camera = name;
    c.view.mm_per_px = 0.4;
    c.view.distance_mm = distance_mm;
    c.view.frame_rate_hz = 1000;
    c.view.exposure_s = 3e-4;
    c.view.dac_triggered = true;
    Target walker{.name = "walker", .kind = side ? TargetKind::rectangle : TargetKind::disc};
    walker.polarity = side ? Polarity::dark : Polarity::bright;
    walker.offset_mm = side ? 15 : 12;
    Target base{
        .name = "base", .kind = side ? TargetKind::bars : TargetKind::dots, .polarity = Polarity::dark};
    base.offset_mm = side ? 20 : 0;
    if (side)
        base.pitch_mm = 5;
    else
        base.diameter_mm = 2.6, base.pitch_mm = 8;
    c.view.targets = {walker, base};
    return c;
}

template <class Visitor>
void visit_camera(Visitor&& v, CameraTruth& c) {
    v("width_px", c.width, {64, 4096});
    v("height_px", c.height, {32, 4096});
    v("mm_per_px", c.view.mm_per_px, {1e-3, 100});
    v("distance_mm", c.view.distance_mm, {0, 1e5});
    v("along_x", c.view.along[0], {-1, 1});
    v("frame_rate_hz", c.view.frame_rate_hz, {1, 1e5});
    v("exposure_s", c.view.exposure_s, {1e-6, 1});
    v("psf_px", c.psf_px, {0.2, 10});
    v("noise_dn", c.noise_dn, {0, 100});
    v("light_gradient", c.light_gradient, {0, 0.9});
    v("latency_s", c.latency_s, {0, 1});
    v("own_clock", c.own_clock, {0, 1});
    v("clock_ppm", c.clock_ppm, {-20000, 20000});
    v("positions", c.positions, {0, 1});
    v.unusual("code_seed", c.code_seed, {0, 1e9}, 0);
    v.unusual("region_off_px", c.region_off_px, {-4096, 4096}, 0);
    v.unusual("true_mm_per_px", c.optics.mm_per_px, {0, 100}, 0);
    v.unusual("true_distance_mm", c.optics.distance_mm, {0, 1e5}, 0);
    v.unusual("true_k1", c.optics.k1, {-10, 10}, 0);
    v.unusual("true_k2", c.optics.k2, {-100, 100}, 0);
    v.unusual("true_tilt_x_deg", c.optics.tilt_x_deg, {-30, 30}, 0);
    v.unusual("true_tilt_y_deg", c.optics.tilt_y_deg, {-30, 30}, 0);
    v.unusual("true_turn_deg", c.optics.turn_deg, {-20, 20}, 0);
    v.words("calibration", c.calibration);
    v.words("boards", c.boards);
    v.unusual("board_s", c.board_s, {0.1, 1e4}, CameraTruth{}.board_s);
}

template <class Part>
void visit_friction(Part& w, WalkerTruth& t) {
    const WalkerTruth usual;
    w.unusual_choice("law", t.law,
                     {walker::friction_laws[0], walker::friction_laws[1], walker::friction_laws[2],
                      walker::friction_laws[3]},
                     usual.law);
    const auto visit = [&](const char* key, double WalkerTruth::*x, Range r) {
        w.unusual(key, t.*x, r, usual.*x);
    };
    visit("viscous_per_s", &WalkerTruth::viscous_per_s, {0, 1000});
    visit("backward_ratio", &WalkerTruth::backward_ratio, {0.1, 10});
    visit("log_share", &WalkerTruth::log_share, {0, 10});
    visit("log_velocity_mps", &WalkerTruth::log_velocity_mps, {1e-6, 10});
    visit("dahl_um", &WalkerTruth::dahl_um, {0.05, 1000});
    visit("stribeck_mps", &WalkerTruth::stribeck_mps, {1e-5, 10});
    visit("mu_jitter", &WalkerTruth::mu_jitter, {0, 0.3});
    visit("mu_memory", &WalkerTruth::mu_memory, {0, 0.9999});
    visit("mu_step_s", &WalkerTruth::mu_step_s, {1e-3, 100});
    visit("mu_relaxation", &WalkerTruth::mu_relaxation, {-0.9, 10});
    visit("relaxation_s", &WalkerTruth::relaxation_s, {1e-3, 1e6});
    visit("ageing", &WalkerTruth::ageing, {0, 1});
    visit("ageing_s", &WalkerTruth::ageing_s, {1e-6, 1000});
    visit("roughness", &WalkerTruth::roughness, {0, 0.2});
    visit("roughness_mm", &WalkerTruth::roughness_mm, {0.01, 1e4});
}

// True gains, cross axes and offsets of the sensor, and the attitudes in which it is held.
template <class Part>
void visit_sensor_errors(Part& part, AccelerometerTruth& a) {
    const AccelerometerTruth usual;
    const std::string axes = "xyz";
    for (std::size_t i = 0; i < 3; ++i) {
        const std::string axis(1, axes[i]);
        part.unusual(("gain_" + axis).c_str(), a.gain[i][i], {-10, 10}, 1);
        part.unusual(("offset_" + axis + "_mps2").c_str(), a.offset_mps2[i], {-1e3, 1e3}, 0);
        for (std::size_t k = 0; k < 3; ++k)
            if (i != k) part.unusual(("cross_" + axis + axes[k]).c_str(), a.gain[i][k], {-10, 10}, 0);
    }
    part.unusual("axes", a.axes, {1, 3}, usual.axes);
    part.unusual("gravity", a.gravity, {0, 1}, usual.gravity);
    part.unusual("high_pass_hz", a.high_pass_hz, {0, 100}, usual.high_pass_hz);
    part.unusual("high_pass_order", a.high_pass_order, {1, 2}, usual.high_pass_order);
    part.unusual("told_high_pass_hz", a.told_high_pass_hz, {-1, 100}, usual.told_high_pass_hz);
    part.unusual("told_low_pass_hz", a.told_low_pass_hz, {0, 20e3}, usual.told_low_pass_hz);
    part.words("calibration", a.calibration);
    part.words("response", a.response);
    part.words("attitudes", a.attitudes);
    part.unusual("hold_s", a.hold_s, {0.1, 1e4}, usual.hold_s);
    part.unusual("turn_s", a.turn_s, {0.01, 1e4}, usual.turn_s);
    part.unusual("held_within_deg", a.held_within_deg, {0, 20}, usual.held_within_deg);
}

template <class Visitor>
void visit(Visitor&& v, Scene& s) {
    v.root("gravity_mps2", s.gravity, {0.1, 100});
    v.root("tilt_deg", s.tilt_deg, {-30, 30});
    auto&& dac = v.table("dac");
    dac("rate_hz", s.dac_rate_hz, {8000, 400e3});
    dac("full_scale_v", s.dac_full_scale_v, {0.01, 100});
    dac("buffer_s", s.dac_buffer_s, {0, 1});
    dac("kept_s", s.dac_kept_s, {0, 1});
    dac.unusual("enable_before_s", s.enable_before_s, {0, 5}, 0);
    v.shaker(s.shaker);
    auto&& w = v.table("walker");
    w("mass_kg", s.walker.mass_kg, {1e-6, 100});
    w("diameter_mm", s.walker.diameter_mm, {1, 1000});
    w("height_mm", s.walker.height_mm, {1, 1000});
    w("mu_k", s.walker.mu_k, {0, 5});
    w("mu_s", s.walker.mu_s, {0, 5});
    w("start_mm", s.walker.start_mm, {-1e4, 1e4});
    visit_friction(w, s.walker);
    auto&& a = v.table("accelerometer");
    a("rate_hz", s.accelerometer.rate_hz, {100, 192e3});
    a("clock_ppm", s.accelerometer.clock_ppm, {-20000, 20000});
    a.unusual("clock_drift_ppm_per_min", s.accelerometer.clock_drift_ppm_per_min, {-100, 100}, 0);
    a.unusual("clock_walk_us_rts", s.accelerometer.clock_walk_us_rts, {0, 100}, 0);
    a("start_s", s.accelerometer.start_s, {0, 1});
    a("lowpass_hz", s.accelerometer.lowpass_hz, {10, 20e3});
    a("noise_mps2_rthz", s.accelerometer.noise_mps2_rthz, {0, 1});
    a("range_mps2", s.accelerometer.range_mps2, {1, 1e5});
    a("bits", s.accelerometer.bits, {8, 31});
    a("yaw_deg", s.accelerometer.yaw_deg, {-180, 180});
    a("axis_told", s.accelerometer.axis_told, {0, 1});
    a("latency_s", s.accelerometer.latency_s, {0, 1});
    a("latency_jitter_s", s.accelerometer.latency_jitter_s, {0, 1});
    a("block_samples", s.accelerometer.block_samples, {1, 64});
    a("mains_hz", s.accelerometer.mains_hz, {0, 1e4});
    a("mains_mps2", s.accelerometer.mains_mps2, {0, 1e3});
    visit_sensor_errors(a, s.accelerometer);
    for (CameraTruth& c : s.cameras) visit_camera(v.table(c.view.camera), c);
}

class Reader {
public:
    explicit Reader(SettingsTable& root) : root_{root} {}
    void root(const char* key, double& x, Range r) { x = root_.number(key, r, x); }
    ReadPart& table(const std::string& name) {
        parts_.push_back({root_.table(name)});
        return parts_.back();
    }
    void shaker(ShakerTruth& s) { s = read_shaker(root_.table("shaker")); }
    void finish() const {
        root_.finish();
        for (const ReadPart& p : parts_) p.table.finish();
    }

private:
    SettingsTable& root_;
    std::list<ReadPart> parts_;
};

class Writer {
public:
    void root(const char* key, double x, Range) {
        text += fmt::format("{} = {}\n", key, WritePart::number(x));
    }
    WritePart table(const std::string& name) {
        text += "\n[" + name + "]\n";
        return {text};
    }
    void shaker(const ShakerTruth& s) { text += shaker_text(s); }
    std::string text;
};

}  // namespace

Scene read_scene(SettingsTable& root, const Scene& standard) {
    Scene s = standard;
    s.seed = static_cast<std::uint64_t>(root.integer("seed", 0, 2147483647, 1));
    Reader reader{root};
    visit(reader, s);
    s.faults = read_faults(root.tables("fault"), {"top", "side"});
    reader.finish();
    if (s.walker.mu_s < s.walker.mu_k && root.table("walker").has("mu_s"))
        root.table("walker").fail(
            "mu_s", fmt::format("{} is below mu_k = {}; static friction must be at least as large "
                                "as kinetic",
                                s.walker.mu_s, s.walker.mu_k));
    s.walker.mu_s = std::max(s.walker.mu_s, s.walker.mu_k);
    if (s.walker.law == walker::FrictionLaw::stribeck && s.walker.mu_k <= 0)
        root.table("walker").fail("mu_k", "must be above 0 with law = \"stribeck\"");
    if (s.walker.law == walker::FrictionLaw::dahl && s.walker.ageing > 0)
        root.table("walker").fail("ageing",
                                  "is allowed only with a law that sticks, not with law = \"dahl\"");
    if (const double most = s.dac_rate_hz / (1 + 1e-6 * s.accelerometer.clock_ppm);
        s.accelerometer.rate_hz > most * (1 + 1e-12))
        root.table("accelerometer")
            .fail("rate_hz", fmt::format("{} Hz is more than the DAC's {} Hz by the sensor's clock",
                                         s.accelerometer.rate_hz, s.dac_rate_hz));
    for (const std::string& name : words_of(s.accelerometer.attitudes))
        if (!direction_of(name))
            root.table("accelerometer")
                .fail("attitudes", "\"" + name +
                                       "\" is not an attitude: expected the axes that point up, for example "
                                       "\"+x -x +y +x-z\"");
    for (CameraTruth& c : s.cameras) {
        if (std::abs(c.view.along[0]) != 1) root.table(c.view.camera).fail("along_x", "must be 1 or -1");
        if (c.view.exposure_s >= 1 / c.view.frame_rate_hz)
            root.table(c.view.camera)
                .fail("exposure_s", fmt::format("{} s does not fit between frames at {} Hz",
                                                c.view.exposure_s, c.view.frame_rate_hz));
        if (!c.boards.empty() && board_places(c.boards).empty())
            root.table(c.view.camera)
                .fail("boards",
                      "expected four numbers for each place of the board: a and b of its middle in mm, its "
                      "turn in degrees, its height in mm; got \"" +
                          c.boards + "\"");
        c.view.positions = c.positions != 0;
    }
    place_regions(s);
    return s;
}

walker::Friction friction_of(const Scene& scene) {
    const WalkerTruth& t = scene.walker;
    walker::Friction f{
        .mu_k = t.mu_k, .mu_s = t.mu_s, .viscous = t.viscous_per_s, .backward = t.backward_ratio};
    f.law = t.law;
    f.log_share = t.log_share;
    f.log_velocity = t.log_velocity_mps;
    f.presliding = 1e-6 * t.dahl_um;
    f.stribeck = t.stribeck_mps;
    f.ageing = t.ageing;
    f.ageing_s = t.ageing_s;
    f.roughness = {.share = t.roughness, .length = 1e-3 * t.roughness_mm, .seed = scene.seed + 7001};
    f.change = {.jitter = t.mu_jitter,
                .memory = t.mu_memory,
                .relaxation = t.mu_relaxation,
                .relaxation_s = t.relaxation_s,
                .seed = scene.seed + 7002};
    return f;
}

Scene paper_scene(Detail detail) {
    Scene s;
    s.cameras = {camera("top", false, 96, 600), camera("side", true, 64, 450)};
    if (detail == Detail::positions)
        for (CameraTruth& c : s.cameras) c.width = 640, c.positions = 1, c.view.positions = true;
    place_regions(s);
    return s;
}

Scene read_scene(const std::filesystem::path& file) {
    SettingsTable root = SettingsTable::from_file(file);
    return read_scene(root);
}

Scene parse_scene(const std::string& toml, const std::string& file_name) {
    SettingsTable root = SettingsTable::from_text(toml, file_name);
    return read_scene(root);
}

std::string scene_text(const Scene& scene) {
    Scene s = scene;
    Writer w;
    w.text = fmt::format("seed = {}\n", s.seed);
    visit(w, s);
    return w.text + faults_text(s.faults);
}

}  // namespace shaker::simulated
