#include "daemon/bench/changed_settings.hpp"

#include <toml++/toml.h>

#include <set>
#include <sstream>

#include "drivers/errors.hpp"

namespace shaker::bench {

namespace {

std::string text_of(const toml::node& node) {
    std::ostringstream out;
    out.imbue(std::locale::classic());
    node.visit([&](const auto& value) { out << value; });
    return out.str();
}

}  // namespace

std::vector<std::string> changed_settings(std::string_view before, std::string_view after) try {
    const toml::table then = toml::parse(before), now = toml::parse(after);
    std::set<std::string> changed;
    for (const auto& [from, to] : {std::pair{&then, &now}, {&now, &then}})
        for (const auto& [key, node] : *from) {
            const toml::node* other = to->get(key);
            if (other == nullptr || text_of(node) != text_of(*other)) changed.emplace(key.str());
        }
    return {changed.begin(), changed.end()};
} catch (const toml::parse_error& e) {
    throw InputError{std::string{e.description()}};
}

}  // namespace shaker::bench
