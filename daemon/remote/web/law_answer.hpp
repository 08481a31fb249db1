#pragma once
// The law against gamma and phi at the set-point, as JSON. It is computed beside the server's thread.
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "daemon/service/bench_state.hpp"
#include "drivers/beside.hpp"

namespace shaker::web {

/// Thread safety: one thread. The destructor waits for a computation under way, which takes some tenths of a
/// second.
class LawAnswer {
public:
    /// The curves of this state; empty while they are computed: then the client asks again.
    std::optional<std::string> of(const service::BenchState& state);

private:
    struct Asked {
        Drive drive;
        calibration::Estimate mu;
        double g = 0, to = 0;  // of the curve against gamma, m/s^2
        [[nodiscard]] bool same(const Asked& other) const;
    };
    static Asked asked_of(const service::BenchState& state);
    static std::string computed(const Asked& asked);

    Asked asked_{};  // of text_ or of under_way_
    std::string text_;
    std::future<std::string> under_way_;
    std::unique_ptr<Beside> beside_ = std::make_unique<Beside>("law", true);  // a Site is moved into place
};

}  // namespace shaker::web
