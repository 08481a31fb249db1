#include "daemon/campaign/run_points.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "daemon/recording/replay.hpp"
#include "daemon/recording/tables/measured_tables.hpp"
#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/errors.hpp"
#include "drivers/settings_table.hpp"

namespace shaker::campaign {

double gravity_in(const recorded::RecordingReader& file) {
    const std::string name = file.file().filename().string() + ": rig_text";
    return SettingsTable::from_text(file.header().rig, name).number("gravity_mps2", {0.1, 100}, paper_g);
}

double add_recording(const std::filesystem::path& recording, std::vector<law::Point>& to) {
    const recorded::RecordingReader file{recording};
    recording::require_known_schema(file);
    double frame_rate_hz = 0;
    for (const View& view : file.header().views)
        if (std::ranges::any_of(view.targets, [](const Target& t) { return t.name == "walker"; }))
            frame_rate_hz = std::max(frame_rate_hz, view.frame_rate_hz);
    const std::size_t before = to.size();
    for (const recording::MeasuredResult& m : recording::read_results(file)) {
        if (!m.reduction) continue;
        law::Point p = law::point_of(*m.reduction, m.measurement.asked);
        p.time_s = recording::seconds_of(m.measurement.time);
        if (file.header().schema < recording::unsmoothed_since) p.kink_frames = law::smoothed_frames;
        if (frame_rate_hz > 0) p.phases_per_period = frame_rate_hz / p.frequency;
        law::add_paired(to, std::move(p));
    }
    if (to.size() == before)
        throw InputError{
            fmt::format("{}: the recording has no measurement with a result", recording.string())};
    return gravity_in(file);
}

}  // namespace shaker::campaign
