#include "daemon/remote/troubles.hpp"

#include <spdlog/fmt/fmt.h>

namespace shaker::remote {

namespace {

std::string words_of(const std::exception_ptr& exception) {
    try {
        std::rethrow_exception(exception);
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "unknown exception";
    }
}

}  // namespace

void Troubles::note(std::string_view where, const std::exception_ptr& exception) noexcept {
    ++count_;
    try {
        const auto now = bench_port_.state();
        bench_port_.log(
            now ? now->now_s : 0, "warning",
            fmt::format("internal error in the remote control, {}: {}", where, words_of(exception)));
    } catch (...) {  // no memory left: the count remains
    }
}

}  // namespace shaker::remote
