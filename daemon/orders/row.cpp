#include "daemon/orders/row.hpp"

#include "daemon/orders/rows.hpp"

namespace shaker::orders {

std::span<const Row> rows() { return table; }

const Row* find(std::string_view name) {
    const std::size_t place = place_of(name);
    return place < table.size() ? &table.at(place) : nullptr;
}

const Row& row(std::string_view name) { return table.at(place_of(name)); }

}  // namespace shaker::orders
