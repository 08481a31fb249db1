#pragma once
// The heartbeats of a bench on call.
#include "daemon/acquisition/channels.hpp"
#include "daemon/run/recordings.hpp"
#include "daemon/service/heartbeats.hpp"

namespace shaker::service {

/// Output: played blocks that the reduction thread has gathered. Recorder: progress of the completion of a
/// recording, which may take minutes; at rest otherwise. Other threads add their own (all()).
class BenchHeartbeats {
public:
    /// Call it after each step of the service.
    void follow(const acquisition::Channels& channels, const run::Recordings& recordings);
    [[nodiscard]] Heartbeats& all() noexcept { return all_; }

private:
    Heartbeats all_;
    Heartbeat& output_ = all_.add("output", std::chrono::milliseconds{300});
    Heartbeat& recorder_ = all_.add("recorder", std::chrono::seconds{60});
    std::int64_t gathered_ = 0;
    std::uint64_t progress_ = 0;
    bool finishing_ = false;
};

}  // namespace shaker::service
