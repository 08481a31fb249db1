#pragma once
// Orders as JSON: the bodies of POST /api/NAME, and the table of orders.
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "daemon/orders/values.hpp"
#include "daemon/service/pending_orders.hpp"

namespace shaker::web {

/// The object of a body, {} for an empty one. InputError for another text.
nlohmann::json object_of(const std::string& body);
/// InputError for a body that has keys.
void require_no_fields(const std::string& body);
/// The order that a body gives. InputError with the key, the value and what is allowed. now: as for made().
service::OrderWhat order_of(const orders::Row& row, const std::string& body,
                            const service::PendingOrders::Settings& now);
/// GET /api/orders: a list of all orders with their fields, for the page and Python.
std::string orders_json();

}  // namespace shaker::web
