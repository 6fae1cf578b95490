/// A COLLADA file as XML: elements by id, numbers, errors that name file and element.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "reference/base/error.h"
#include "scenes/affine.h"

namespace scotty::scenes {

class ColladaDocument {
 public:
    /// Throws reference::Error (bad_input) for a file that is not readable, well-formed COLLADA.
    explicit ColladaDocument(std::string path);

    pugi::xml_node root() const { return root_; }
    /// Whether anything in it uses Scotty3D's CMU462 extras.
    bool made_for_scotty3d() const {
        return !root_.select_node("//*[local-name()='technique'][@profile='CMU462']")
                    .node()
                    .empty();
    }
    /// The element that "#id" points to, inside this file. Throws where there is none, or where it
    /// is not one of `kind`; `user` is the element that refers to it.
    pugi::xml_node target(pugi::xml_node user, const char* attribute, const char* kind) const;

    /// An error at an element: "scene.dae: <light id="Area">: what".
    reference::Error error(pugi::xml_node element, const std::string& what) const;

    /// All numbers of an element's text. Throws, naming the first thing that is no finite number.
    std::vector<double> numbers(pugi::xml_node element) const;
    /// Exactly `count` numbers.
    std::vector<double> numbers(pugi::xml_node element, std::size_t count) const;
    /// One number, or `standard` where the element is not there.
    double number(pugi::xml_node element, double standard) const;
    /// The first three of an element's three or four numbers.
    Point colour(pugi::xml_node element) const;
    /// All whole numbers >= 0 of an element's text.
    std::vector<std::uint32_t> indices(pugi::xml_node element) const;
    /// A whole-number attribute, or `standard` where it is not there.
    std::uint32_t count_attribute(pugi::xml_node element, const char* name,
                                  std::uint32_t standard) const;

 private:
    std::string path_;
    pugi::xml_document xml_;
    pugi::xml_node root_;
    std::unordered_map<std::string, pugi::xml_node> by_id_;
};

/// The element below <extra><technique profile="CMU462">, empty where there is none.
pugi::xml_node scotty3d_extra(pugi::xml_node element);

}  // namespace scotty::scenes
