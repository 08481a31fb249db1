#include "drivers/simulated/faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "drivers/simulated/settings_parts.hpp"

namespace shaker::simulated {

namespace {

struct Description {
    std::string_view name;
    Range value{0, 0};       // allowed range; 0 to 0: the kind has no value
    bool lasts = false;      // accepts for_s
    bool must_end = false;   // requires for_s
    bool of_camera = false;  // accepts a camera's name
};

constexpr Range factor{-1e6, 1e6}, count{1, 1e6};

// In the order of FaultKind.
constexpr std::array<Description, 22> descriptions{{
    {.name = "open", .lasts = true},
    {.name = "frozen", .lasts = true},
    {.name = "saturated", .lasts = true},
    {.name = "flipped", .lasts = true},
    {.name = "swapped", .lasts = true},
    {.name = "gain", .value = factor, .lasts = true},
    {.name = "drop", .value = count},
    {.name = "silent", .lasts = true, .must_end = true},
    {.name = "amplifier_gain", .value = factor},
    {.name = "walker_off"},
    {.name = "walker_on"},
    {.name = "underrun", .value = count},
    {.name = "camera_stall", .lasts = true, .must_end = true, .of_camera = true},
    {.name = "camera_lose", .of_camera = true},
    {.name = "walker_hidden", .lasts = true, .of_camera = true},
    {.name = "held_back", .lasts = true, .must_end = true},
    {.name = "camera_gone", .of_camera = true},
    {.name = "late", .value = {1e-6, 1}, .lasts = true},
    {.name = "contact_open", .lasts = true},
    {.name = "amplifier_off", .lasts = true},
    {.name = "bad_sample", .value = {-1e5, 1e5}},
    {.name = "frozen_axis", .lasts = true},
}};

const Description& description(FaultKind what) { return descriptions[static_cast<std::size_t>(what)]; }

FaultKind read_kind(SettingsTable& table) {
    const std::string name = table.text("what");
    const auto found = std::ranges::find(descriptions, name, &Description::name);
    if (found == descriptions.end()) {
        std::string known;
        for (const Description& d : descriptions) known += (known.empty() ? "" : ", ") + std::string{d.name};
        table.fail("what", fmt::format("\"{}\" is not a fault; expected one of {}", name, known));
    }
    return static_cast<FaultKind>(std::distance(descriptions.begin(), found));
}

SceneFault read_fault(SettingsTable& table, std::initializer_list<std::string_view> cameras) {
    SceneFault f;
    f.what = read_kind(table);
    const Description& d = description(f.what);
    f.at_s = table.number("at_s", {0, 1e9});
    if (d.must_end || (d.lasts && table.has("for_s"))) f.for_s = table.number("for_s", {0, 1e9});
    if (d.value.max > 0) f.value = table.number("value", d.value);
    if (d.of_camera && table.has("camera")) f.camera = cameras.begin()[table.choice("camera", cameras)];
    table.finish();
    return f;
}

std::vector<SceneFault> of_kinds(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
                                 std::string_view camera) {
    std::vector<SceneFault> chosen;
    std::ranges::copy_if(all, std::back_inserter(chosen), [&](const SceneFault& f) {
        return std::ranges::count(kinds, f.what) > 0 && (f.camera.empty() || f.camera == camera);
    });
    std::ranges::stable_sort(chosen, {}, &SceneFault::at_s);
    return chosen;
}

}  // namespace

std::vector<SceneFault> read_faults(std::vector<SettingsTable> tables,
                                    std::initializer_list<std::string_view> cameras) {
    std::vector<SceneFault> faults;
    faults.reserve(tables.size());
    for (SettingsTable& table : tables) faults.push_back(read_fault(table, cameras));
    return faults;
}

std::string faults_text(const std::vector<SceneFault>& faults) {
    std::string text;
    for (const SceneFault& f : faults) {
        const Description& d = description(f.what);
        text += fmt::format("\n[[fault]]\nwhat = \"{}\"\nat_s = {}\n", d.name, WritePart::number(f.at_s));
        if (std::isfinite(f.for_s)) text += fmt::format("for_s = {}\n", WritePart::number(f.for_s));
        if (d.value.max > 0) text += fmt::format("value = {}\n", WritePart::number(f.value));
        if (!f.camera.empty()) text += fmt::format("camera = \"{}\"\n", f.camera);
    }
    return text;
}

FaultQueue::FaultQueue(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
                       std::string_view camera)
    : faults_{of_kinds(all, kinds, camera)} {}

const SceneFault* FaultQueue::take(double t) noexcept {
    if (next_ == faults_.size() || faults_[next_].at_s > t) return nullptr;
    return &faults_[next_++];
}

LastingFaults::LastingFaults(const std::vector<SceneFault>& all, std::initializer_list<FaultKind> kinds,
                             std::string_view camera)
    : faults_{of_kinds(all, kinds, camera)} {}

bool LastingFaults::at(FaultKind what, double t) const noexcept {
    return std::ranges::any_of(faults_, [&](const SceneFault& f) { return f.what == what && f.lasts_at(t); });
}

bool LastingFaults::between(FaultKind what, double from, double to) const noexcept {
    return std::ranges::any_of(faults_, [&](const SceneFault& f) {
        return f.what == what && f.at_s <= to && f.at_s + f.for_s > from;
    });
}

double LastingFaults::growth_at(FaultKind what, double t) const noexcept {
    double sum = 0;
    for (const SceneFault& f : faults_)
        if (f.what == what) sum += f.value * std::clamp(t - f.at_s, 0.0, f.for_s);
    return sum;
}

double LastingFaults::product_at(FaultKind what, double t) const noexcept {
    double product = 1;
    for (const SceneFault& f : faults_)
        if (f.what == what && f.lasts_at(t)) product *= f.value;
    return product;
}

}  // namespace shaker::simulated
