#include "tests/system/contract/bad_bodies.h"

#include <boost/json.hpp>

namespace faultlab::tests {
namespace {

namespace json = boost::json;

constexpr int kDepthMax = 3;
constexpr std::int64_t kItemsMax = 600;

class Generator {
 public:
  Generator(const json::object& document, const json::object& good)
      : document_(document), root_(good) {}

  std::vector<BadBody> Run(const json::value& schema) {
    for (const char* text : {"", "{", "[]", "null", "7", "\"x\"", "{\"a\":1,}", "\xFF\xFE"}) {
      out_.push_back({"not an object", text});
    }
    out_.push_back({"too deep", std::string(5000, '[') + std::string(5000, ']')});
    Object(schema, "", 0);
    return std::move(out_);
  }

 private:
  const json::object& Resolve(const json::value& schema) const {
    const json::object& object = schema.as_object();
    if (const json::value* ref = object.if_contains("$ref")) {
      const std::string name(ref->as_string());
      const std::string key = name.substr(name.rfind('/') + 1);
      return Resolve(document_.at("components").at("schemas").at(key));
    }
    // Of several alternatives the first object is used: the mistakes are made in it.
    if (const json::value* one_of = object.if_contains("oneOf")) {
      for (const json::value& option : one_of->as_array()) {
        const json::object& resolved = Resolve(option);
        if (resolved.contains("properties")) return resolved;
      }
      return Resolve(one_of->as_array().front());
    }
    return object;
  }

  void Add(const std::string& mistake, const std::string& pointer, const json::value& value) {
    json::value copy = root_;
    const std::size_t slash = pointer.rfind('/');
    const std::string name = pointer.substr(slash + 1);
    boost::system::error_code ec;
    json::value* parent = copy.find_pointer(pointer.substr(0, slash), ec);
    if (parent == nullptr) return;
    if (parent->is_object()) {
      parent->as_object()[name] = value;
    } else if (parent->is_array() && !parent->as_array().empty()) {
      parent->as_array().front() = value;
    }
    out_.push_back({mistake + " " + pointer, json::serialize(copy)});
  }

  void Object(const json::value& schema_value, const std::string& at, int depth) {
    const json::object& schema = Resolve(schema_value);
    Add("unknown", at + "/no_such_field", 1);
    if (const json::value* required = schema.if_contains("required")) {
      for (const json::value& name : required->as_array())
        Missing(at, std::string(name.as_string()));
    }
    const json::value* properties = schema.if_contains("properties");
    if (properties == nullptr || depth >= kDepthMax) return;
    for (const auto& [name, property] : properties->as_object()) {
      Member(property, at + "/" + std::string(name), depth);
    }
  }

  void Missing(const std::string& at, const std::string& name) {
    json::value copy = root_;
    boost::system::error_code ec;
    json::value* parent = at.empty() ? &copy : copy.find_pointer(at, ec);
    if (parent == nullptr || !parent->is_object()) return;
    parent->as_object().erase(name);
    out_.push_back({"missing " + at + "/" + name, json::serialize(copy)});
  }

  void Member(const json::value& property, const std::string& at, int depth) {
    const json::object& schema = Resolve(property);
    for (const json::value& value : WrongTypes()) Add("wrong", at, value);
    if (const json::value* most = schema.if_contains("maxLength")) {
      Add("too long", at, json::string(std::string(most->to_number<std::size_t>() + 1, 'x')));
    }
    if (const json::value* high = schema.if_contains("maximum")) {
      Add("too large", at, high->to_number<double>() * 2 + 1);
    }
    if (const json::value* low = schema.if_contains("minimum")) {
      Add("too small", at, low->to_number<double>() - 1);
    }
    const json::value* old = Old(at);
    if (schema.contains("properties") && old != nullptr && old->is_object()) {
      Object(property, at, depth + 1);
    }
    const json::value* items = schema.if_contains("items");
    if (items == nullptr || old == nullptr || !old->is_array() || old->as_array().empty()) return;
    const json::value* most = schema.if_contains("maxItems");
    if (most != nullptr && most->to_number<std::int64_t>() < kItemsMax) {
      json::array many(most->to_number<std::size_t>() + 1, old->as_array().front());
      Add("too many", at, many);
    }
    Member(*items, at + "/0", depth + 1);
  }

  const json::value* Old(const std::string& at) const {
    boost::system::error_code ec;
    return root_.find_pointer(at, ec);
  }

  static const std::vector<json::value>& WrongTypes() {
    static const std::vector<json::value> kValues = {nullptr,
                                                     true,
                                                     -1,
                                                     1.5,
                                                     1e300,
                                                     std::int64_t{9'000'000'000'000'000'000},
                                                     "",
                                                     "no such word",
                                                     json::string("\x01\x1b[2J"),
                                                     "\xF0\x9F\x92\xA9\xE2\x80\xAE' OR 1=1 --",
                                                     json::string(std::string(70'000, 'x')),
                                                     json::array{},
                                                     json::array{json::array{1}},
                                                     json::object{},
                                                     json::object{{"a", json::object{}}}};
    return kValues;
  }

  const json::object& document_;
  const json::value root_;
  std::vector<BadBody> out_;
};

}  // namespace

std::vector<BadBody> BadBodies(const json::object& document,
                               const json::value& schema,
                               const json::object& good) {
  return Generator(document, good).Run(schema);
}

}  // namespace faultlab::tests
