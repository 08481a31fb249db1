#include "daemon/acquisition/moved_targets.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/view_settings.hpp"

namespace shaker::acquisition {

namespace {

// The entry of this name, or an InputError that lists the names.
template <class Entry>
Entry& named(std::vector<Entry>& entries, std::string Entry::*name, const std::string& wanted,
             const std::string& what) {
    const auto found = std::ranges::find(entries, wanted, name);
    if (found != entries.end()) return *found;
    std::vector<std::string> names;
    for (const Entry& e : entries) names.push_back(e.*name);
    throw InputError{
        fmt::format("{} \"{}\" does not exist; expected \"{}\"", what, wanted, fmt::join(names, "\", \""))};
}

}  // namespace

std::string text(const MovedTarget& moved) {
    return fmt::format("camera \"{}\", target \"{}\", roi_px = [{}]", moved.camera, moved.target,
                       fmt::join(moved.roi_px, ", "));
}

std::vector<View> with_regions(std::vector<View> views, std::span<const MovedTarget> moved) {
    if (moved.empty()) throw InputError{"no target was given; expected camera, target and region"};
    for (auto m = moved.begin(); m != moved.end(); ++m) {
        View& view = named(views, &View::camera, m->camera, "camera");
        Target& target =
            named(view.targets, &Target::name, m->target, fmt::format("camera \"{}\", target", m->camera));
        if (std::any_of(moved.begin(), m, [&](const MovedTarget& before) {
                return before.camera == m->camera && before.target == m->target;
            }))
            throw InputError{text(*m) + ": a second region of this target; expected one"};
        try {
            target.roi_px = roi_of(m->roi_px);
        } catch (const InputError& e) {
            throw InputError{text(*m) + ": " + e.what()};
        }
    }
    return views;
}

}  // namespace shaker::acquisition
