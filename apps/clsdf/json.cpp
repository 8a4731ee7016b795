#include "json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>
#include <variant>

using nlohmann::ordered_json;

using Elements = std::vector<Json>;
using Members = std::vector<Json::Member>;

/// A scalar, an array or an object.
struct Json::Content {
    std::variant<ordered_json, Elements, Members> value;

    template <class Kind>
    static const Kind& of(const Json& json) {
        if (!json.content_) throw std::bad_variant_access();
        return std::get<Kind>(json.content_->value);
    }

    static ordered_json printable(const Json& json);
    static Json parsed(const ordered_json& json);
};

ordered_json Json::Content::printable(const Json& json) {
    if (!json.content_) return nullptr;
    const auto& value = json.content_->value;
    if (const auto* elements = std::get_if<Elements>(&value)) {
        ordered_json array = ordered_json::array();
        for (const Json& element : *elements) array.push_back(printable(element));
        return array;
    }
    if (const auto* members = std::get_if<Members>(&value)) {
        ordered_json object = ordered_json::object();
        for (const Member& member : *members) object[member.name] = printable(member.value);
        return object;
    }
    return std::get<ordered_json>(value);
}

Json Json::Content::parsed(const ordered_json& json) {
    if (json.is_null()) return {};
    if (json.is_array()) {
        Json array = Json::array();
        for (const ordered_json& element : json) array.push_back(parsed(element));
        return array;
    }
    if (json.is_object()) {
        Json object = Json::object();
        for (const auto& [name, value] : json.items()) object[name] = parsed(value);
        return object;
    }
    return Json(Content{json});
}

Json::Json(Content content) : content_(std::make_unique<Content>(std::move(content))) {}

Json::Json() noexcept = default;
Json::Json(bool truth) : Json(Content{ordered_json(truth)}) {}
Json::Json(int number) : Json(Content{ordered_json(number)}) {}
Json::Json(unsigned number) : Json(Content{ordered_json(number)}) {}
Json::Json(long number) : Json(Content{ordered_json(number)}) {}
Json::Json(unsigned long number) : Json(Content{ordered_json(number)}) {}
Json::Json(long long number) : Json(Content{ordered_json(number)}) {}
Json::Json(unsigned long long number) : Json(Content{ordered_json(number)}) {}
Json::Json(double number) : Json(Content{ordered_json(number)}) {}
Json::Json(const char* text) : Json(Content{ordered_json(text)}) {}
Json::Json(const std::string& text) : Json(Content{ordered_json(text)}) {}
Json::Json(std::initializer_list<Member> members) : Json(Content{Members(members)}) {}

Json::Json(const Json& other) : content_(other.content_ ? std::make_unique<Content>(*other.content_) : nullptr) {}
Json::Json(Json&& other) noexcept = default;
Json::~Json() = default;

Json& Json::operator=(Json other) noexcept {
    content_.swap(other.content_);
    return *this;
}

Json Json::array() {
    return Json(Content{Elements()});
}

Json Json::object() {
    return Json(Content{Members()});
}

Json Json::parse(const std::string& text) {
    return Content::parsed(ordered_json::parse(text));
}

void Json::push_back(Json element) {
    if (!content_) *this = array();
    std::get<Elements>(content_->value).push_back(std::move(element));
}

Json& Json::operator[](std::string_view name) {
    if (!content_) *this = object();
    auto& members = std::get<Members>(content_->value);
    const auto member = std::ranges::find(members, name, &Member::name);
    return member != members.end() ? member->value : members.emplace_back(std::string(name)).value;
}

void Json::update(const Json& object) {
    for (const Member& member : Content::of<Members>(object)) (*this)[member.name] = member.value;
}

double Json::number() const {
    return Content::of<ordered_json>(*this).get<double>();
}

std::string Json::text() const {
    return Content::of<ordered_json>(*this).get<std::string>();
}

const std::vector<Json>& Json::elements() const {
    return Content::of<Elements>(*this);
}

const Json& Json::operator[](std::string_view name) const {
    static const Json null;
    const auto& members = Content::of<Members>(*this);
    const auto member = std::ranges::find(members, name, &Member::name);
    return member != members.end() ? member->value : null;
}

std::string Json::dump() const {
    return Content::printable(*this).dump(2, ' ', false, ordered_json::error_handler_t::replace);
}
