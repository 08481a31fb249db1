#pragma once
// Subscriptions of a page to live streams, received as text over its socket.
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace shaker::web {

inline constexpr std::size_t most_streams = 16;  // per socket

/// A subscription to one stream.
struct Subscription {
    std::string stream;
    std::size_t width = 800;  // px, 1 to 4096
    double rate_hz = 10;      // 0.1 to 30
};
/// Request in a client's text: a subscription, or its end ("end" is true). Empty if it is neither.
struct Wish {
    bool end = false;
    Subscription what;
};
std::optional<Wish> wish_of(std::string_view text);
/// True for {"type": "abort"}.
bool is_abort(std::string_view text);

/// Adds or removes the stream, up to the limit of streams. Stream: state of each, with its `wish`.
template <class Stream>
void take(const Wish& wish, std::map<std::string, Stream>& streams) {
    const std::string& name = wish.what.stream;
    if (wish.end)
        streams.erase(name);
    else if (streams.size() < most_streams || streams.contains(name))
        streams[name].wish = wish.what;
}

}  // namespace shaker::web
