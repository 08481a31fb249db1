#include "daemon/recording/tables/track_changes.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "daemon/recording/tables/track_table.hpp"

namespace shaker::recording {

namespace {

// Places in px; `states`: pictures in which a target is in another state (found, degraded, lost).
struct Moved {
    double squares = 0, most = 0, variances = 0;
    std::size_t both = 0, states = 0;
};

Moved between(const std::vector<tracking::Track>& then, const std::vector<tracking::Track>& now) {
    Moved m;
    for (std::size_t i = 0; i < std::min(then.size(), now.size()); ++i) {
        const tracking::Fix &a = then[i].fix, &b = now[i].fix;
        m.states += a.state != b.state ? 1 : 0;
        const double distance = std::hypot(b.x_px - a.x_px, b.y_px - a.y_px);
        if (!std::isfinite(distance)) continue;
        ++m.both;
        m.squares += distance * distance;
        m.most = std::max(m.most, distance);
        m.variances += b.sd_px * b.sd_px;
    }
    return m;
}

}  // namespace

std::vector<std::string> track_changes(const recorded::RecordingReader& file,
                                       const acquisition::Streams& now) {
    acquisition::Streams then;
    read_tracks(file, file.header(), then);
    std::vector<std::string> changes;
    for (std::size_t i = 0; i < std::min(then.tracks.size(), now.tracks.size()); ++i) {
        const acquisition::TargetTrack& t = now.tracks[i];
        const Moved m = between(then.tracks[i].tracks, t.tracks);
        if (m.most == 0 && m.states == 0) continue;
        const double n = static_cast<double>(std::max<std::size_t>(m.both, 1));
        changes.push_back(fmt::format(
            "{}: {:.2g} px rms, at most {:.2g} (stated error {:.2g}); another state in {} of {} pictures",
            track_path(t.camera, t.target), std::sqrt(m.squares / n), m.most, std::sqrt(m.variances / n),
            m.states, t.tracks.size()));
    }
    return changes;
}

}  // namespace shaker::recording
