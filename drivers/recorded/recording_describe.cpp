#include "drivers/recorded/recording_describe.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::recorded {

namespace {

// m/s^2 on the first axis per count on the second.
std::string cross_name(std::size_t i, std::size_t k) {
    return fmt::format("cross_mps2_per_count_{}{}", "xyz"[i], "xyz"[k]);
}

constexpr std::array<std::pair<const char*, double Lens::*>, 5> lens_numbers{
    {{"lens_focal_px", &Lens::focal_px},
     {"lens_k1", &Lens::k1},
     {"lens_k2", &Lens::k2},
     {"lens_p1", &Lens::p1},
     {"lens_p2", &Lens::p2}}};

// Only values that differ from the defaults: earlier versions read the views without it.
void describe_lens(hid_t group, const View& view) {
    if (!view.calibration.empty()) h5::set_attribute(group, "calibration", view.calibration);
    if (view.lens.focal_px <= 0) return;
    for (const auto& [name, number] : lens_numbers) h5::set_attribute(group, name, view.lens.*number);
    for (std::size_t k = 0; k < 2; ++k) {
        h5::set_attribute(group, fmt::format("lens_centre_{}_px", "xy"[k]), view.lens.centre_px[k]);
        h5::set_attribute(group, fmt::format("tilt_{}_deg", "xy"[k]), view.tilt_deg[k]);
    }
}

void read_lens(hid_t entry, const std::string& path, View& view) {
    if (h5::has_attribute(entry, path, "calibration"))
        view.calibration = h5::read_attribute_text(entry, path, "calibration");
    if (!h5::has_attribute(entry, path, "lens_focal_px")) return;
    for (const auto& [name, number] : lens_numbers) view.lens.*number = h5::read_attribute(entry, path, name);
    for (std::size_t k = 0; k < 2; ++k) {
        view.lens.centre_px[k] = h5::read_attribute(entry, path, fmt::format("lens_centre_{}_px", "xy"[k]));
        view.tilt_deg[k] = h5::read_attribute(entry, path, fmt::format("tilt_{}_deg", "xy"[k]));
    }
}

void describe_response(hid_t group, const SensorResponse& response) {
    const auto part = [&](const std::string& pass, const auto& p, double usual_damping) {
        if (p.none()) return;
        h5::set_attribute(group, pass + "_hz", p.hz);
        h5::set_attribute(group, pass + "_error_hz", p.error_hz);
        h5::set_attribute(group, pass + "_order", static_cast<double>(p.poles));
        if (p.damping != usual_damping) h5::set_attribute(group, pass + "_damping", p.damping);
    };
    part("high_pass", response.lower, LowerCorner{}.damping);
    part("low_pass", response.upper, LowPass{}.damping);
    if (response.upper.above_hz > 0) h5::set_attribute(group, "low_pass_above_hz", response.upper.above_hz);
    if (!response.file.empty()) h5::set_attribute(group, "response", response.file);
}

}  // namespace

void describe(hid_t group, const DacInfo& dac) {
    h5::set_attribute(group, "name", dac.name);
    h5::set_attribute(group, "rate_hz", dac.rate_hz);
    h5::set_attribute(group, "full_scale_V", dac.full_scale_V);
}

void describe(hid_t group, const AccelerometerInfo& a) {
    h5::set_attribute(group, "name", a.name);
    h5::set_attribute(group, "rate_hz", a.rate_hz);
    h5::set_attribute(group, "first_sample_s", a.first_sample_s);
    h5::set_attribute(group, "clock_uncertainty_s", a.clock_uncertainty_s);
    if (a.axes != 3) h5::set_attribute(group, "axes", static_cast<double>(a.axes));
    if (!a.gravity) h5::set_attribute(group, "gravity", 0.0);
    describe_response(group, a.response);
    if (a.dac_clock) h5::set_attribute(group, "dac_clock", 1.0);
    for (std::size_t k = 0; k < 3; ++k) {
        h5::set_attribute(group, fmt::format("offset_counts_{}", "xyz"[k]), a.offset_counts[k]);
        h5::set_attribute(group, fmt::format("mps2_per_count_{}", "xyz"[k]), a.mps2_per_count[k]);
        h5::set_attribute(group, fmt::format("shaker_axis_{}", "xyz"[k]), a.shaker_axis[k]);
    }
    if (a.calibration.empty()) return;
    h5::set_attribute(group, "calibration", a.calibration);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (i != k) h5::set_attribute(group, cross_name(i, k), a.cross_mps2_per_count[i][k]);
}

void describe(hid_t group, const View& view) {
    h5::set_attribute(group, "mm_per_px", view.mm_per_px);
    if (view.scale_error != 0) h5::set_attribute(group, "scale_error", view.scale_error);
    h5::set_attribute(group, "distance_mm", view.distance_mm);
    h5::set_attribute(group, "along_x", view.along[0]);
    h5::set_attribute(group, "along_y", view.along[1]);
    h5::set_attribute(group, "frame_rate_hz", view.frame_rate_hz);
    h5::set_attribute(group, "exposure_s", view.exposure_s);
    h5::set_attribute(group, "dac_triggered", std::int64_t{view.dac_triggered});
    h5::set_attribute(group, "trigger_delay_s", view.trigger_delay_s);
    h5::set_attribute(group, "arrival_delay_s", view.arrival_delay_s);
    describe_lens(group, view);
    if (view.positions) h5::set_attribute(group, "positions", std::int64_t{1});
    for (std::size_t k = 0; k < 2; ++k)
        h5::set_attribute(group, fmt::format("origin_{}_px", "xy"[k]), std::int64_t{view.origin_px[k]});
    std::int64_t order = 0;
    for (const Target& t : view.targets) {
        const h5::Handle g = h5::make_group(group, "targets/" + t.name, "NXcollection");
        h5::set_attribute(g.get(), "order", order++);
        h5::set_attribute(g.get(), "kind", std::int64_t{static_cast<int>(t.kind)});
        h5::set_attribute(g.get(), "polarity", std::int64_t{static_cast<int>(t.polarity)});
        h5::set_attribute(g.get(), "diameter_mm", t.diameter_mm);
        h5::set_attribute(g.get(), "width_mm", t.width_mm);
        h5::set_attribute(g.get(), "pitch_mm", t.pitch_mm);
        h5::set_attribute(g.get(), "offset_mm", t.offset_mm);
        for (std::size_t k = 0; k < 4; ++k)
            h5::set_attribute(g.get(), fmt::format("roi_{}_px", "xywh"[k]), std::int64_t{t.roi_px[k]});
    }
}

DacInfo read_dac(hid_t entry, const std::string& path) {
    return {h5::read_attribute_text(entry, path, "name"), h5::read_attribute(entry, path, "rate_hz"),
            h5::read_attribute(entry, path, "full_scale_V")};
}

int whole_attribute(hid_t at, const std::string& path, const std::string& name, int min, int max) {
    const double v = h5::read_attribute(at, path, name);
    if (!(v >= min && v <= max && v == std::floor(v)))
        throw InputError{"recording: " + path + "@" + name + " = " + std::to_string(v) +
                         " is not an integer in " + std::to_string(min) + ".." + std::to_string(max)};
    return static_cast<int>(v);
}

std::size_t place_of(hid_t entry, const std::string& path, std::size_t count) {
    return static_cast<std::size_t>(whole_attribute(entry, path, "order", 0, static_cast<int>(count) - 1));
}

View read_view(hid_t entry, const std::string& camera) {
    const std::string path = "raw/" + camera;
    View view;
    view.camera = camera;
    view.mm_per_px = h5::read_attribute(entry, path, "mm_per_px");
    if (h5::has_attribute(entry, path, "scale_error"))
        view.scale_error = h5::read_attribute(entry, path, "scale_error");
    view.distance_mm = h5::read_attribute(entry, path, "distance_mm");
    view.along = {h5::read_attribute(entry, path, "along_x"), h5::read_attribute(entry, path, "along_y")};
    view.frame_rate_hz = h5::read_attribute(entry, path, "frame_rate_hz");
    view.exposure_s = h5::read_attribute(entry, path, "exposure_s");
    view.dac_triggered = whole_attribute(entry, path, "dac_triggered", 0, 1) != 0;
    view.trigger_delay_s = h5::read_attribute(entry, path, "trigger_delay_s");
    view.arrival_delay_s = h5::read_attribute(entry, path, "arrival_delay_s");
    read_lens(entry, path, view);
    view.positions =
        h5::has_attribute(entry, path, "positions") && whole_attribute(entry, path, "positions", 0, 1) != 0;
    for (std::size_t k = 0; k < 2; ++k)
        view.origin_px[k] = whole_attribute(entry, path, std::string{"origin_"} + "xy"[k] + "_px", 0, 100000);
    const std::vector<std::string> names = h5::names_in(entry, path + "/targets");
    view.targets.resize(names.size());
    for (const std::string& name : names) {
        const std::string at = fmt::format("{}/targets/{}", path, name);
        Target& t = view.targets[place_of(entry, at, names.size())];
        if (!t.name.empty())
            throw InputError{"recording: " + at + "@order is used by \"" + t.name + "\" too"};
        t.name = name;
        t.kind = static_cast<TargetKind>(
            whole_attribute(entry, at, "kind", 0, static_cast<int>(TargetKind::code)));
        t.polarity = static_cast<Polarity>(whole_attribute(entry, at, "polarity", 0, 1));
        t.diameter_mm = h5::read_attribute(entry, at, "diameter_mm");
        t.width_mm = h5::read_attribute(entry, at, "width_mm");
        t.pitch_mm = h5::read_attribute(entry, at, "pitch_mm");
        t.offset_mm = h5::read_attribute(entry, at, "offset_mm");
        for (std::size_t k = 0; k < 4; ++k)
            t.roi_px[k] =
                whole_attribute(entry, at, std::string{"roi_"} + "xywh"[k] + "_px", -100000, 100000);
    }
    return view;
}

namespace {

SensorResponse read_response(hid_t entry, const std::string& path) {
    SensorResponse out;
    const auto number = [&](const std::string& name, double least, double most) {
        const double x = h5::read_attribute(entry, path, name.c_str());
        if (x >= least && x <= most) return x;
        throw InputError{
            fmt::format("recording: {}@{} is {}; {} to {} is allowed", path, name, x, least, most)};
    };
    const auto part = [&](const std::string& pass, auto& p, int least_poles) {
        if (!h5::has_attribute(entry, path, pass + "_hz")) return;
        p.hz = number(pass + "_hz", 0, 1e6);
        p.error_hz = number(pass + "_error_hz", 0, INFINITY);
        p.poles = whole_attribute(entry, path, pass + "_order", least_poles, 2);
        if (h5::has_attribute(entry, path, pass + "_damping")) p.damping = number(pass + "_damping", 0.3, 2);
    };
    part("high_pass", out.lower, 0);
    part("low_pass", out.upper, 1);
    if (h5::has_attribute(entry, path, "low_pass_above_hz"))
        out.upper.above_hz = number("low_pass_above_hz", 1, 1e6);
    if (h5::has_attribute(entry, path, "response"))
        out.file = h5::read_attribute_text(entry, path, "response");
    return out;
}

}  // namespace

AccelerometerInfo read_accelerometer(hid_t entry, const std::string& path) {
    AccelerometerInfo a;
    a.name = h5::read_attribute_text(entry, path, "name");
    a.rate_hz = h5::read_attribute(entry, path, "rate_hz");
    a.first_sample_s = h5::read_attribute(entry, path, "first_sample_s");
    a.clock_uncertainty_s = h5::read_attribute(entry, path, "clock_uncertainty_s");
    if (h5::has_attribute(entry, path, "axes")) a.axes = whole_attribute(entry, path, "axes", 1, 3);
    if (h5::has_attribute(entry, path, "gravity"))
        a.gravity = whole_attribute(entry, path, "gravity", 0, 1) != 0;
    a.response = read_response(entry, path);
    if (h5::has_attribute(entry, path, "dac_clock"))
        a.dac_clock = whole_attribute(entry, path, "dac_clock", 0, 1) != 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string axis(1, "xyz"[k]);
        a.offset_counts[k] = h5::read_attribute(entry, path, "offset_counts_" + axis);
        a.mps2_per_count[k] = h5::read_attribute(entry, path, "mps2_per_count_" + axis);
        a.shaker_axis[k] = h5::read_attribute(entry, path, "shaker_axis_" + axis);
    }
    if (!h5::has_attribute(entry, path, "calibration")) return a;
    a.calibration = h5::read_attribute_text(entry, path, "calibration");
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (i != k) a.cross_mps2_per_count[i][k] = h5::read_attribute(entry, path, cross_name(i, k));
    return a;
}

}  // namespace shaker::recorded
