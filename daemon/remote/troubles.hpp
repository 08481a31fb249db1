#pragma once
// Troubles: exceptions that reached the end of a task of the server's thread. The task ended or begins again;
// the thread goes on.
#include <cstdint>
#include <exception>
#include <string_view>

#include "daemon/service/bench_port.hpp"

namespace shaker::remote {

/// Used on the server's thread.
class Troubles {
public:
    explicit Troubles(service::BenchPort& bench_port) : bench_port_{bench_port} {}
    /// Counts the exception and writes it to the log. where: the task, "accepting of SCPI connections".
    void note(std::string_view where, const std::exception_ptr& exception) noexcept;
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

private:
    service::BenchPort& bench_port_;
    std::uint64_t count_ = 0;
};

}  // namespace shaker::remote
