#include "daemon/replayed_take.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "daemon/acquisition.hpp"
#include "daemon/executors.hpp"
#include "daemon/recorder.hpp"

namespace shaker {

namespace {

// Data as slowly as they came, and a line each second.
class SlowReplay {
public:
    void look(const Take& take) {
        if (take.blocks.empty()) return;
        const double now_s = static_cast<double>(take.blocks.back().first.n) / take.accelerometer.rate_hz;
        pacer_.wait_until(now_s);
        if (now_s < told_s_ + 1) return;
        told_s_ = now_s;
        std::string line = fmt::format("{:9.3f} s  {} frames", now_s, take.frames);
        for (const TargetTrack& t : take.tracks)
            if (!t.tracks.empty())
                line += fmt::format("  {}/{} {:.3f} mm", t.camera, t.target.name, 1e3 * t.tracks.back().x_m);
        spdlog::info("{}", line);
    }

private:
    Pacer pacer_;
    double told_s_ = 0;
};

Take streams_of(const SessionReader& file, const SessionHeader& header, bool pictures, bool real_time) {
    Rig rig = replay_rig(file, header, pictures);
    Acquisition acquisition{rig, nullptr};
    SlowReplay slow;
    read_all(acquisition, [&] {
        if (real_time) slow.look(acquisition.take());
    });
    Take take = std::move(acquisition.take());
    take.dac_rate_hz = header.dac.rate_hz;
    take.played = file.play_times();
    take.changes = file.changes();
    return take;
}

}  // namespace

Take replayed_take(const SessionReader& file, const SessionHeader& header, bool pictures, bool real_time,
                   std::vector<std::string>& notes) {
    Take take = streams_of(file, header, pictures, real_time);
    if (pictures)
        settle_times(take, notes);
    else
        read_tracks(file, header, take);
    return take;
}

Take stored_take(const SessionReader& file, std::vector<std::string>& notes) {
    const SessionHeader& header = file.header();
    Take take = streams_of(file, header, false, false);
    read_tracks(file, header, take);
    std::size_t first = 0;
    for (const View& view : header.views) {
        CameraTake& camera = take.cameras.emplace_back();
        camera.view = view;
        camera.first_track = std::exchange(first, first + view.targets.size());
        for (const Frame& f : file.frames(view.camera))
            if (!f.mid_exposure) camera.untimed.push_back({f.tick, f.stamp, f.arrived});
    }
    settle_times(take, notes);
    return take;
}

}  // namespace shaker
