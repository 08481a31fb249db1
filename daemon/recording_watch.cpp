#include "daemon/recording_watch.hpp"

#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>

namespace shaker {

namespace {
constexpr double most_backlog = 0.8;  // of what may wait
}

void RecordingWatch::look(Director& director, const Take& take, Lanes& lanes) {
    if (!recording_.on()) return;
    const double now_s =
        take.played.empty() ? 0 : static_cast<double>(take.played.back().tick.n) / take.dac_rate_hz;
    if (!begun_ || director.state() != state_) {
        begun_ = true;
        state_ = director.state();
        recording_.add(LogEntry{now_s, name(state_), {}});
    }
    if (director.to_s() > director.from_s() &&
        (director.from_s() != measured_.from_s || director.to_s() != measured_.to_s)) {
        measured_ = {director.from_s(), director.to_s()};
        recording_.add(measured_);
    }
    for (; notes_ < director.notes().size(); ++notes_)
        recording_.add(LogEntry{now_s, name(state_), director.notes()[notes_]});
    if (!recording_.failure() && recording_.backlog() < most_backlog) {
        well_s_ = now_s;
        return;
    }
    if (stopped_ || director.trip()) return;
    stopped_ = true;
    director.stop(lanes, {.cause = Cause::recorder, .value = now_s - well_s_});
}

std::string new_identifier() { return to_string(boost::uuids::random_generator{}()); }

}  // namespace shaker
