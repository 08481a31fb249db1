#pragma once
// What a page asks for over its socket: live streams, by text.
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace shaker::web {

inline constexpr std::size_t most_streams = 16;  // of one socket

/// A client's wish for a stream.
struct Subscription {
    std::string stream;
    std::size_t width = 800;  // px, 1 to 4096
    double rate_hz = 10;      // 0.1 to 30
};
/// What a client's text asks for: a subscription, or its end ("un" is true). Empty for what is neither.
struct Wish {
    bool end = false;
    Subscription what;
};
std::optional<Wish> wish_of(std::string_view text);

/// Does it, unless there are as many streams as there may be. Stream: what is kept of each, `wish` among it.
template <class Stream>
void take(const Wish& wish, std::map<std::string, Stream>& streams) {
    const std::string& name = wish.what.stream;
    if (wish.end)
        streams.erase(name);
    else if (streams.size() < most_streams || streams.contains(name))
        streams[name].wish = wish.what;
}

}  // namespace shaker::web
