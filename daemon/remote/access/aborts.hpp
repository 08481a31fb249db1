#pragma once
// Aborts: gives the aborts of all clients to the output and watches that the output obeys them.
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace shaker::access {

/// Used on the thread that serves the clients; no function waits.
class Aborts {
public:
    enum class Answer : std::uint8_t {
        none,    // not yet, and still within `patience`
        obeyed,  // the output ramps to zero, or was silent and latched already
        silent,  // the output did not answer in time
    };
    /// The answer to one abort. Call it until it is not `none`.
    using Receipt = std::function<Answer()>;
    struct Output {
        std::function<std::uint64_t(const std::string& by)> stop;  // stops the drive; number of this abort
        std::function<std::uint64_t()> obeyed;  // number of the newest abort that the output has obeyed
    };

    static constexpr std::chrono::milliseconds patience{100};
    static constexpr const char* silent_text = "the output does not answer: cut the amplifier";

    explicit Aborts(Output output) : output_{std::move(output)} {}

    /// Stops the drive at once. by: name of the client.
    Receipt give(const std::string& by);
    /// Sets a function that is called after each abort: what waits to be ordered by other clients is dropped.
    void after(std::function<void(const std::string& by)> given) { given_ = std::move(given); }

private:
    Output output_;
    std::function<void(const std::string& by)> given_;
};

}  // namespace shaker::access
