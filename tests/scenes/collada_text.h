/// COLLADA documents for tests, put together from pieces.
#pragma once

#include <string>

#include "tests/scenes/temporary_files.h"

namespace scotty::tests {

/// A square from (0,0,0) to (1,1,0) as one polygon of four corners, normals +z, symbol "paint".
inline const std::string kSquare = R"(<geometry id="square"><mesh>
<source id="sp"><float_array id="spa" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
<technique_common><accessor source="#spa" count="4" stride="3"/></technique_common></source>
<source id="sn"><float_array id="sna" count="3">0 0 1</float_array>
<technique_common><accessor source="#sna" count="1" stride="3"/></technique_common></source>
<vertices id="sv"><input semantic="POSITION" source="#sp"/></vertices>
<polylist material="paint" count="1"><input semantic="VERTEX" source="#sv" offset="0"/>
<input semantic="NORMAL" source="#sn" offset="1"/><vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>
</mesh></geometry>)";

struct ColladaText {
    std::string up_axis = "Y_UP";
    std::string unit = "1";
    std::string geometry = kSquare;
    std::string extra;  ///< in the effect, profile CMU462
    std::string common = "<lambert><diffuse><color>0.1 0.2 0.3 1</color></diffuse></lambert>";
    std::string light =
        "<technique_common><ambient><color>1 1 1</color></ambient></technique_common>";
    std::string optics = "<perspective><yfov>60</yfov></perspective>";
    std::string mesh_transform;
    std::string light_transform;
    std::string camera_transform = "<translate>0 0 5</translate>";
    std::string more_nodes;
    std::string libraries;
    bool has_camera = true;
    bool has_light = true;

    std::string text() const {
        const std::string cmu = extra.empty() ? ""
                                              : "<extra><technique profile=\"CMU462\">" + extra +
                                                    "</technique></extra>";
        std::string out =
            "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><asset><unit meter=\"" + unit +
            "\"/><up_axis>" + up_axis + "</up_axis></asset>" + libraries;
        out += "<library_cameras><camera id=\"cam\"><optics><technique_common>" + optics +
               "</technique_common></optics></camera></library_cameras>";
        out += "<library_lights><light id=\"lamp\">" + light + "</light></library_lights>";
        out += "<library_effects><effect id=\"fx\"><profile_COMMON><technique sid=\"common\">" +
               common + "</technique></profile_COMMON>" + cmu + "</effect></library_effects>";
        out +=
            "<library_materials><material id=\"mat\"><instance_effect url=\"#fx\"/></material>"
            "</library_materials>";
        out += "<library_geometries>" + geometry + "</library_geometries>";
        out += "<library_visual_scenes><visual_scene id=\"s\"><node id=\"mesh\">" + mesh_transform +
               "<instance_geometry url=\"#square\"><bind_material><technique_common>"
               "<instance_material symbol=\"paint\" target=\"#mat\"/></technique_common>"
               "</bind_material></instance_geometry></node>";
        if (has_light) {
            out +=
                "<node id=\"light\">" + light_transform + "<instance_light url=\"#lamp\"/></node>";
        }
        if (has_camera) {
            out += "<node id=\"camera\">" + camera_transform +
                   "<instance_camera url=\"#cam\"/></node>";
        }
        return out + more_nodes +
               "</visual_scene></library_visual_scenes>"
               "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
    }
};

/// The scene of a document, as a file with this specification's end loads it.
inline reference::Scene load(const ColladaText& text, const std::string& suffix = "") {
    return TemporaryFiles().load("scene.dae", text.text(), suffix);
}

/// An extra for a light: "<extra>..CMU462..".
inline std::string light_extra(const std::string& content) {
    return "<technique_common><point><color>9 9 9</color></point></technique_common>"
           "<extra><technique profile=\"CMU462\">" +
           content + "</technique></extra>";
}

}  // namespace scotty::tests
