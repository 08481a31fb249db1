#include "daemon/commands/calibrate/board_pictures.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include "daemon/bench/bench.hpp"
#include "daemon/run/stop_signals.hpp"
#include "drivers/errors.hpp"
#include "drivers/time.hpp"
#include "drivers/trigger_train.hpp"

namespace shaker::commands {

namespace {

using calibration::PlacedBoard;
using calibration::SeenBoard;

constexpr double still_px = 0.1, moved_px = 5, board_patience_s = 300, pictures_hz = 10;

// Root mean square distance of the corners that both have; infinite when there are fewer than four.
double distance_px(const SeenBoard& a, const SeenBoard& b) {
    constexpr int least = 4;
    double squares = 0;
    int count = 0;
    for (const auto& corner : a.corners) {
        const auto same =
            std::ranges::lower_bound(b.corners, corner.number, {}, &calibration::SeenCorner::number);
        if (same == b.corners.end() || same->number != corner.number) continue;
        squares +=
            std::pow(corner.at_px[0] - same->at_px[0], 2) + std::pow(corner.at_px[1] - same->at_px[1], 2);
        ++count;
    }
    return count >= least ? std::sqrt(squares / count) : std::numeric_limits<double>::infinity();
}

// Silence and triggers on the DAC: by this thread on virtual time, else by its own, as long as it lives.
class SilentDrive {
public:
    SilentDrive(bench::Bench& bench, bool triggered)
        : dac_{*bench.rig.dac},
          silence_(dac_.info().block_frames),
          trigger_(silence_.size()),
          train_{dac_.info().rate_hz, pictures_hz},
          step_s_{duration_s(static_cast<std::int64_t>(silence_.size()), dac_.info().rate_hz)} {
        if (!bench.world && triggered)
            own_ = std::jthread{[this](const std::stop_token& stop) {
                while (!stop.stop_requested()) write();
            }};
    }
    void write() {
        train_.fill(trigger_);
        dac_.write(silence_, trigger_);
    }
    [[nodiscard]] double step_s() const { return step_s_; }

private:
    Dac& dac_;
    std::vector<double> silence_, trigger_;
    TriggerTrain train_;
    double step_s_;
    std::jthread own_{};
};

class LeadBoard {
public:
    LeadBoard(const manual::Values& values, const BoardOptions& options,
              const std::function<void(const std::string&)>& show)
        : name_{values.text("--camera")},
          on_base_{values.whole("--pictures")},
          raised_{std::max(1, on_base_ / 3)},
          hold_s_{values.number("--hold")},
          options_{options},
          show_{show},
          bench_{bench::open_bench(values.text("--rig"), values.text("--scene"),
                                   simulated::World::Pace::lockstep)},
          camera_{find()},
          drive_{bench_, camera_.view().dac_triggered} {
        if (camera_.view().positions)
            throw InputError{fmt::format("camera \"{}\": gives positions and no pictures", name_)};
    }

    BoardPictures run() {
        const int all = on_base_ + (options_.raised_mm > 0 ? raised_ : 0);
        show_(fmt::format("lay the board on the base; {} pictures, each in another place and turned\n",
                          on_base_));
        while (static_cast<int>(taken_.boards.size()) < all) {
            run::StopSignals::rethrow();
            const FramePtr frame = newest();
            if (frame == nullptr) {
                if (camera_.ended()) throw DeviceError{fmt::format("camera \"{}\": has ended", name_)};
                if (waited_s_ > board_patience_s)
                    throw InputError{
                        fmt::format("camera \"{}\": no picture of a board at rest within {:.0f} s: {}", name_,
                                    board_patience_s, why_not_)};
                continue;
            }
            look(*frame);
        }
        taken_.view = camera_.view();
        return std::move(taken_);
    }

private:
    Camera& find() {
        std::string names;
        for (const auto& camera : bench_.rig.cameras) {
            if (camera->view().camera == name_) return *camera;
            names += (names.empty() ? "" : ", ") + camera->view().camera;
        }
        throw InputError{fmt::format("--camera {}: no such camera; the rig has {}", name_, names)};
    }

    // The last picture that has arrived; others are not needed.
    FramePtr newest() {
        FramePtr frame;
        if (bench_.world) {
            drive_.write();
            waited_s_ += drive_.step_s();
            time_s_ += drive_.step_s();
            AccelBlock block;
            while (bench_.rig.accelerometer->read(block, std::chrono::milliseconds{0})) continue;
            for (const auto& other : bench_.rig.cameras)
                while (const FramePtr f = other->read(std::chrono::milliseconds{0}))
                    if (other.get() == &camera_) frame = f;
            return frame;
        }
        constexpr std::chrono::milliseconds wait{100};
        const auto began = std::chrono::steady_clock::now();
        frame = camera_.read(wait);
        while (const FramePtr next = frame ? camera_.read(std::chrono::milliseconds{0}) : nullptr)
            frame = next;
        const auto now = std::chrono::steady_clock::now();
        waited_s_ += std::chrono::duration<double>(now - began).count();
        time_s_ = std::chrono::duration<double>(now.time_since_epoch()).count();
        return frame;
    }

    void look(const Frame& frame) {
        SeenBoard seen = calibration::find_board(calibration::grey_picture(frame.view()), options_.board,
                                                 fmt::format("picture {}", taken_.boards.size() + 1));
        constexpr std::size_t least = 8;
        if (seen.corners.size() < least) {
            why_not_ = fmt::format("{} corners ({} markers) found; at least {} are needed",
                                   seen.corners.size(), seen.markers, least);
            resting_.reset();
            return;
        }
        if (!resting_ || distance_px(seen, *resting_) > still_px) {
            why_not_ = "the board moves";
            resting_ = std::move(seen);
            rest_s_ = time_s_;
            return;
        }
        if (!taken_.boards.empty() && distance_px(seen, taken_.boards.back().seen) < moved_px) {
            why_not_ = "the board was not moved since the last picture";
            return;
        }
        if (time_s_ - rest_s_ < hold_s_) return;
        take(std::move(seen));
    }

    void take(SeenBoard seen) {
        const bool raised = static_cast<int>(taken_.boards.size()) >= on_base_;
        show_(fmt::format("{}{}: {} corners, blur {:.2f} px\n", seen.name, raised ? " (raised)" : "",
                          seen.corners.size(), seen.blur));
        taken_.boards.push_back({std::move(seen), options_.thickness_mm + (raised ? options_.raised_mm : 0)});
        waited_s_ = 0;
        resting_.reset();
        if (options_.raised_mm > 0 && static_cast<int>(taken_.boards.size()) == on_base_)
            show_(
                fmt::format("now raise the board by {:.4g} mm; {} pictures\n", options_.raised_mm, raised_));
    }

    std::string name_;      // of the camera
    int on_base_, raised_;  // pictures; raised_ after them, if the board is raised
    double hold_s_;
    BoardOptions options_;
    const std::function<void(const std::string&)>& show_;
    bench::Bench bench_;
    Camera& camera_;
    SilentDrive drive_;
    BoardPictures taken_{};
    std::optional<SeenBoard> resting_{};
    double time_s_ = 0, rest_s_ = 0, waited_s_ = 0;
    std::string why_not_ = "no picture came";
};

}  // namespace

std::vector<PlacedBoard> boards_in(const std::vector<std::string>& files, const BoardOptions& options,
                                   double offset_mm) {
    std::vector<PlacedBoard> found;
    for (const std::string& file : files)
        found.push_back({calibration::find_board(calibration::read_picture(file), options.board, file),
                         options.thickness_mm + offset_mm});
    return found;
}

BoardPictures lead_board(const manual::Values& values, const BoardOptions& options,
                         const std::function<void(const std::string&)>& show) {
    const run::StopSignals signals;
    return LeadBoard{values, options, show}.run();
}

}  // namespace shaker::commands
