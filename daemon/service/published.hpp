#pragma once
// Published quantities: one row for each scalar of the bench's state that the page's state, SCPI or /metrics
// give to clients.
#include <cstdint>
#include <span>
#include <string>
#include <variant>

#include "daemon/service/bench_state.hpp"

namespace shaker::service {

/// Empty: not known at present.
using PublishedValue = std::variant<std::monostate, bool, std::uint64_t, double>;

struct Published {
    const char* json;    // place in the page's state, as a JSON pointer; null: not there
    const char* header;  // SCPI: header of a query; null: none
    const char* metric;  // without "shakerd_"; a counter ends with _total; null: none
    const char* unit;    // empty: yes or no, a count, a ratio
    const char* help;
    PublishedValue (*value)(const BenchState&);

    /// "peak of the drive, V"
    [[nodiscard]] std::string text() const;
};
std::span<const Published> published_quantities() noexcept;

}  // namespace shaker::service
