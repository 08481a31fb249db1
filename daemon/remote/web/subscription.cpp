#include "daemon/remote/web/subscription.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace shaker::web {

std::optional<Wish> wish_of(std::string_view text) {
    const nlohmann::json j = nlohmann::json::parse(text, nullptr, false);
    if (!j.is_object() || !j.contains("type") || !j.contains("stream")) return std::nullopt;
    if (!j["type"].is_string() || !j["stream"].is_string()) return std::nullopt;
    const std::string type = j["type"];
    if (type != "subscribe" && type != "unsubscribe") return std::nullopt;
    Wish wish{.end = type == "unsubscribe", .what = {.stream = j["stream"]}};
    if (wish.what.stream.size() > 64) return std::nullopt;
    if (j.contains("width") && j["width"].is_number())
        wish.what.width = static_cast<std::size_t>(std::clamp(j["width"].get<double>(), 1.0, 4096.0));
    if (j.contains("rate_hz") && j["rate_hz"].is_number())
        wish.what.rate_hz = std::clamp(j["rate_hz"].get<double>(), 0.1, 30.0);
    return wish;
}

bool is_abort(std::string_view text) {
    const nlohmann::json j = nlohmann::json::parse(text, nullptr, false);
    return j.is_object() && j.contains("type") && j["type"] == "abort";
}

}  // namespace shaker::web
