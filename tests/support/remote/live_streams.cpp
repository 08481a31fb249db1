#include "tests/support/remote/live_streams.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <stop_token>
#include <thread>

#include "daemon/recording/tables/places.hpp"
#include "daemon/recording/time_text.hpp"
#include "drivers/errors.hpp"
#include "tests/mock/converter.hpp"

namespace shaker::test {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_of(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

double thread_cpu_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

recorded::RecordingHeader header_of(const LiveStreams& streams) {
    recorded::RecordingHeader h;
    h.title = "streams in real time";
    h.kind = "run";
    h.started = recording::local_time_text();
    h.frequency_hz = 20;
    h.dac = {"none", streams.dac_rate_hz, 1, streams.dac_block};
    h.accelerometer.name = "none";
    h.accelerometer.rate_hz = streams.accelerometer_rate_hz;
    h.pictures = recorded::KeptPictures::off;
    for (const char* camera : {"top", "side"}) {
        View view;
        view.camera = camera;
        view.mm_per_px = 0.1;
        view.frame_rate_hz = streams.frame_rate_hz;
        view.targets = {{.name = "walker"}, {.name = "base"}};
        h.views.push_back(view);
    }
    h.groups = recording::recording_places(h, false);
    return h;
}

// Delivers all data that are due at a time after the start.
class Feeder {
public:
    Feeder(recording::Recorder& recording, const LiveStreams& streams)
        : recording_{recording}, streams_{streams} {}
    void feed(double until_s) {
        while (static_cast<double>(tick_) < until_s * streams_.dac_rate_hz) {
            recording_.add(PlayTime{{tick_}, mock::host_now()});
            if (tick_ % (8 * static_cast<std::int64_t>(streams_.dac_block)) ==
                0) {  // changes of the drive, 25 per second
                DriveChange change;
                change.first = {tick_};
                recording_.add(change);
            }
            tick_ += static_cast<std::int64_t>(streams_.dac_block);
        }
        while (static_cast<double>(sample_ + AccelBlock::capacity) <=
               until_s * streams_.accelerometer_rate_hz) {
            AccelBlock block{.first = {sample_}, .arrived = mock::host_now()};
            for (auto& c : block.counts) c = {static_cast<std::int32_t>(sample_ % 977), 2, 3};
            recording_.add(block);
            sample_ += block.size;
        }
        for (; static_cast<double>(frame_) <= until_s * streams_.frame_rate_hz; ++frame_)
            for (std::size_t camera = 0; camera < 2; ++camera) {
                Frame frame;
                frame.tick = {frame_};
                frame.arrived = mock::host_now();
                tracking::Track track;
                track.tick = frame.tick;
                track.time = master_time(static_cast<double>(frame_) / streams_.frame_rate_hz);
                track.x_m = 1e-3 * std::sin(0.1 * static_cast<double>(frame_));
                recording_.add(camera, frame, std::array{track, track}, {});
            }
    }

private:
    recording::Recorder& recording_;
    LiveStreams streams_;
    std::int64_t tick_ = 0, sample_ = 0, frame_ = 0;
};

}  // namespace

LiveCost record_live(const std::filesystem::path& file, const LiveStreams& streams) {
    LiveCost cost;
    {
        recording::Recorder recording{file, header_of(streams), {.live = true}};
        std::jthread recorder{[&](const std::stop_token& stop) {
            while (!stop.stop_requested()) {
                const auto before = Clock::now();
                const bool any = recording.step();
                cost.longest_step_s = std::max(cost.longest_step_s, seconds_of(Clock::now() - before));
                if (!any) std::this_thread::sleep_for(std::chrono::milliseconds{1});
            }
            cost.recorder_s = thread_cpu_s();
        }};
        Feeder feeder{recording, streams};
        const auto begin = Clock::now();
        constexpr std::chrono::milliseconds each{5};
        for (auto due = begin + each; seconds_of(due - begin) < streams.seconds; due += each) {
            std::this_thread::sleep_until(due);
            const auto before = Clock::now();
            const double cpu_s = thread_cpu_s();
            feeder.feed(seconds_of(due - begin));
            cost.feeder_s += thread_cpu_s() - cpu_s;
            cost.longest_add_s = std::max(cost.longest_add_s, seconds_of(Clock::now() - before));
            cost.worst_behind_s = std::max(cost.worst_behind_s, seconds_of(before - due));
        }
        cost.wall_s = seconds_of(Clock::now() - begin);
        recorder.request_stop();
        recorder.join();
        if (const auto why = recording.failure()) throw DeviceError{*why};
        cost.lost = recording.lost();
        recording.finish(acquisition::Streams{});
    }
    cost.bytes = std::filesystem::file_size(file);
    return cost;
}

}  // namespace shaker::test
