#include "drivers/view_settings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/errors.hpp"

namespace shaker {
namespace {

constexpr Range length_mm{1e-4, 1e5};
constexpr Range frame_rate_hz{1e-3, 1e8};
constexpr double unit_length_tolerance = 1e-3;

/// A vector whose length must be 1 within the tolerance, normalised.
template <std::size_t size>
std::array<double, size> unit_vector(SettingsTable& table, std::string_view key) {
    const std::vector<double> given = table.numbers(key, size);
    double length = 0;
    for (const double c : given) length = std::hypot(length, c);
    if (!(std::abs(length - 1) <= unit_length_tolerance))
        table.fail(key, "expected a vector of length 1, got length " + to_text(length));
    std::array<double, size> unit{};
    for (std::size_t i = 0; i < size; ++i) unit[i] = given[i] / length;
    return unit;
}

/// Names become parts of file names, column names and text tables.
std::string name_at(SettingsTable& table, std::set<std::string>& taken) {
    std::string name = table.text("name");
    const auto odd = [](unsigned char c) { return c < ' ' || c == ',' || c == '"' || c == '/' || c == 0x7F; };
    if (name.empty() || std::any_of(name.begin(), name.end(), odd))
        table.fail("name", "expected a name without commas, quotes, slashes or control characters");
    if (!taken.insert(name).second) table.fail("name", "\"" + name + "\" is used twice; names must differ");
    return name;
}

std::array<int, 4> read_roi(SettingsTable& table) {
    const std::vector<double> given = table.numbers("roi_px", 4);
    try {
        return roi_of(std::span{given}.first<4>());
    } catch (const InputError& e) {
        table.fail("roi_px", e.what());
    }
}

Target read_target(SettingsTable& table, std::set<std::string>& names, double distance_mm) {
    Target target;
    target.name = name_at(table, names);
    target.kind = static_cast<TargetKind>(table.choice("kind", target_kinds));
    const auto length = [&](std::string_view key, std::initializer_list<TargetKind> needed_by) {
        const bool needed = std::find(needed_by.begin(), needed_by.end(), target.kind) != needed_by.end();
        return needed ? table.number(key, length_mm) : table.number(key, length_mm, 0);
    };
    target.diameter_mm = length("diameter_mm", {TargetKind::disc, TargetKind::dots});
    target.width_mm = length("width_mm", {TargetKind::rectangle});
    target.pitch_mm = length("pitch_mm", {TargetKind::bars});
    if (target.kind == TargetKind::dots && target.pitch_mm > 0 && target.pitch_mm <= target.diameter_mm)
        table.fail("pitch_mm", "must be more than diameter_mm, which is " + to_text(target.diameter_mm));
    target.roi_px = read_roi(table);
    target.offset_mm = table.number("offset_mm", {-1e5, 1e5}, 0);
    if (distance_mm > 0 && target.offset_mm >= distance_mm)
        table.fail("offset_mm", "must be less than the camera's distance_mm, " + to_text(distance_mm) +
                                    "; got " + to_text(target.offset_mm));
    target.polarity =
        table.choice("polarity", {"bright", "dark"}, 0) == 0 ? Polarity::bright : Polarity::dark;
    table.finish();
    return target;
}

Lens read_lens(SettingsTable table) {
    constexpr Range px{-1e5, 1e5}, distortion{-100, 100};
    Lens lens;
    const std::vector<double> centre = table.numbers("centre_px", 2);
    for (std::size_t k = 0; k < 2; ++k) {
        if (!(px.min <= centre[k] && centre[k] <= px.max))
            table.fail("centre_px", "expected px in -100000..100000, got " + to_text(centre[k]));
        lens.centre_px[k] = centre[k];
    }
    lens.focal_px = table.number("focal_px", {1, 1e7});
    lens.k1 = table.number("k1", distortion, 0);
    lens.k2 = table.number("k2", distortion, 0);
    lens.p1 = table.number("p1", distortion, 0);
    lens.p2 = table.number("p2", distortion, 0);
    table.finish();
    return lens;
}

std::array<double, 2> read_tilt(SettingsTable& table) {
    constexpr double most_deg = 60;
    if (!table.has("lens")) table.fail("tilt_deg", "needs a table [camera.lens] with centre_px and focal_px");
    const std::vector<double> tilt = table.numbers("tilt_deg", 2);
    for (const double deg : tilt)
        if (!(std::abs(deg) <= most_deg))
            table.fail("tilt_deg", "expected degrees in -60..60, got " + to_text(deg));
    return {tilt[0], tilt[1]};
}

}  // namespace

std::array<int, 4> roi_of(std::span<const double, 4> numbers) {
    constexpr double most_px = 65536;
    std::array<int, 4> roi{};
    for (std::size_t i = 0; i < 4; ++i) {
        const double least = i < 2 ? 0 : 1;
        if (numbers[i] != std::floor(numbers[i]) || !(least <= numbers[i] && numbers[i] <= most_px))
            throw InputError{
                "expected x, y, width, height in whole pixels, x and y at least 0, width and height at "
                "least 1; got " +
                to_text(numbers[i])};
        roi[i] = static_cast<int>(numbers[i]);
    }
    return roi;
}

std::array<double, 3> read_shaker_axis(SettingsTable& table, std::size_t axes) {
    constexpr std::string_view key = "shaker_axis";
    if (table.is_text(key) || !table.has(key)) {
        table.choice(key, {"fit"}, 0);
        return {axes == 1 ? 1.0 : 0.0, 0, 0};
    }
    const std::array<double, 3> axis = unit_vector<3>(table, key);
    for (std::size_t k = axes; k < 3; ++k)
        if (axis[k] != 0)
            table.fail(key, "has a part along " + std::string(1, "xyz"[k]) +
                                ", which the sensor does not measure: it has " + std::to_string(axes) +
                                (axes == 1 ? " axis" : " axes"));
    return axis;
}

SensorResponse read_response(SettingsTable& table, bool gravity) {
    constexpr Range damping{0.3, 2};
    if (gravity && table.has("high_pass_hz") && table.number("high_pass_hz", {0, 100}) > 0)
        table.fail("high_pass_hz",
                   "a sensor whose reading has gravity is coupled down to DC (gravity = true)");
    SensorResponse out;
    const auto read = [&](const std::string& pass, auto& part, Range allowed) {
        part.hz = table.number(pass + "_hz", allowed);
        part.error_hz =
            table.number(pass + "_error_hz", {0, allowed.max}, LowerCorner::of_data_sheet * part.hz);
        part.poles = table.integer(pass + "_order", 1, 2, part.poles);
        if (part.poles == 2) part.damping = table.number(pass + "_damping", damping, part.damping);
    };
    if (table.has("low_pass_hz"))
        read("low_pass", out.upper, {10, 1e6});
    else
        out.upper.above_hz = table.number("low_pass_above_hz", {0, 1e6}, 0);
    if (table.has("high_pass_hz"))
        read("high_pass", out.lower, {0, 100});
    else if (!gravity)
        out.lower = {.error_hz = std::numeric_limits<double>::infinity(),
                     .poles = table.integer("high_pass_order", 1, 2, 0)};
    return out;
}

View read_view(SettingsTable& table, std::set<std::string>& taken) {
    View view;
    view.camera = name_at(table, taken);
    if (table.has("frame_rate_hz")) view.frame_rate_hz = table.number("frame_rate_hz", frame_rate_hz);
    view.exposure_s = table.number("exposure_s", {0, 1e3}, 0);
    if (view.exposure_s * view.frame_rate_hz > 1)
        table.fail("exposure_s", "must be at most the time between frames, " +
                                     to_text(1 / view.frame_rate_hz) + " s at frame_rate_hz = " +
                                     to_text(view.frame_rate_hz) + "; got " + to_text(view.exposure_s));
    view.mm_per_px = table.number("mm_per_px", {1e-6, 1e4});
    view.scale_error = table.number("scale_error", {0, 1}, 0);
    view.distance_mm = table.number("distance_mm", {1, 1e7}, 0);
    if (table.has("along")) view.along = unit_vector<2>(table, "along");
    if (table.has("lens")) view.lens = read_lens(table.table("lens"));
    if (table.has("tilt_deg")) view.tilt_deg = read_tilt(table);
    std::set<std::string> target_names;
    for (SettingsTable& target : table.tables("target"))
        view.targets.push_back(read_target(target, target_names, view.distance_mm));
    if (view.targets.empty())
        table.fail("target",
                   "camera \"" + view.camera + "\" has no target; add at least one [[camera.target]]");
    return view;
}

std::string view_text(const View& view) {
    std::string text;
    const auto number = [&](const char* key, double x) {
        if (x != 0) text += key + (" = " + to_text(x)) + "\n";
    };
    const auto pair = [&](const char* key, const std::array<double, 2>& x) {
        text += key;
        text += " = [" + to_text(x[0]) + ", " + to_text(x[1]) + "]\n";
    };
    text += "name = \"" + view.camera + "\"\n";
    number("frame_rate_hz", view.frame_rate_hz);
    number("exposure_s", view.exposure_s);
    number("mm_per_px", view.mm_per_px);
    number("scale_error", view.scale_error);
    number("distance_mm", view.distance_mm);
    pair("along", view.along);
    if (view.lens.focal_px > 0) {
        pair("tilt_deg", view.tilt_deg);
        text += "[camera.lens]\n";
        pair("centre_px", view.lens.centre_px);
        number("focal_px", view.lens.focal_px);
        number("k1", view.lens.k1);
        number("k2", view.lens.k2);
        number("p1", view.lens.p1);
        number("p2", view.lens.p2);
    }
    for (const Target& t : view.targets) {
        text +=
            "[[camera.target]]\nname = \"" + t.name + "\"\nkind = \"" + std::string{word(t.kind)} + "\"\n";
        number("diameter_mm", t.diameter_mm);
        number("width_mm", t.width_mm);
        number("pitch_mm", t.pitch_mm);
        number("offset_mm", t.offset_mm);
        text += "roi_px = [";
        for (std::size_t i = 0; i < 4; ++i) text += (i == 0 ? "" : ", ") + std::to_string(t.roi_px[i]);
        text += t.polarity == Polarity::dark ? "]\npolarity = \"dark\"\n" : "]\n";
    }
    return text;
}

}  // namespace shaker
