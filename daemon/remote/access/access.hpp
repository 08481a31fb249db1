#pragma once
// Access rules of the daemon's HTTP side: allowed host names, origins of pages, token for other machines.
#include <string>
#include <string_view>
#include <vector>

namespace shaker::access {

struct Access {
    std::vector<std::string>
        hosts;          // host names of the daemon, without a port; include "localhost" and "127.0.0.1"
    std::string token;  // empty: no token is required

    /// Rejects a page of another site that reaches the daemon under its own name (DNS rebinding): that name
    /// is in `Host`.
    [[nodiscard]] bool host_allowed(std::string_view host) const;
    /// True if the page's origin is the host it was loaded from, or without an origin (not a page).
    [[nodiscard]] bool origin_allowed(std::string_view origin, std::string_view host) const;
    /// Comparison in constant time: the duration does not depend on the number of correct characters.
    [[nodiscard]] bool token_allowed(std::string_view given) const noexcept;
};

}  // namespace shaker::access
