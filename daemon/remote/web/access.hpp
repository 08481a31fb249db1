#pragma once
// Who may talk to the daemon over HTTP: names it answers to, origins of pages, the token of other machines.
#include <string>
#include <string_view>
#include <vector>

namespace shaker::web {

struct Access {
    std::vector<std::string>
        hosts;          // names it answers to, without a port; "localhost" and "127.0.0.1" among them
    std::string token;  // empty: none is asked for

    /// A page of another site that was led here by a name of its own has that name in `Host`.
    [[nodiscard]] bool host_allowed(std::string_view host) const;
    /// A page's origin must be what it was loaded from; no origin: no page asks.
    [[nodiscard]] bool origin_allowed(std::string_view origin, std::string_view host) const;
    /// In a time that does not tell how much of it is right.
    [[nodiscard]] bool token_allowed(std::string_view given) const noexcept;
};

}  // namespace shaker::web
