#!/usr/bin/env bash
# `make_nav2_msgs.sh VENV` adds `nav2_msgs.action.NavigateToPose` of Jazzy, for which there is no package, to an
# environment of Python that has ros-jazzy-rclpy, ros-jazzy-nav-msgs and numpy. The generators come with these; it needs
# gcc, g++ and Python's headers.
set -euo pipefail
VENV=$(realpath "$1")
BUILD=$(mktemp -d)
trap 'rm -rf "$BUILD"' EXIT
SITE=$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["purelib"])')
mkdir -p "$BUILD/nav2_msgs/action"
cd "$BUILD/nav2_msgs"
cat > action/NavigateToPose.action <<'ACTION'
geometry_msgs/PoseStamped pose
string behavior_tree
---
uint16 NONE=0
uint16 error_code
string error_msg
---
geometry_msgs/PoseStamped current_pose
builtin_interfaces/Duration navigation_time
builtin_interfaces/Duration estimated_time_remaining
int16 number_of_recoveries
float32 distance_remaining
ACTION

# `rosidl generate` finds each of its extensions twice in these packages, and gives up; so they are called here.
AMENT_PREFIX_PATH=$VENV "$VENV/bin/python" - <<'PYTHON' > "$BUILD/log"
import sys
from pathlib import Path
from rosidl_adapter.action import convert_action_to_idl
from rosidl_generator_c.cli import GenerateC
from rosidl_generator_py.cli import GeneratePython
from rosidl_generator_type_description.cli import HashTypeDescription
from rosidl_typesupport_c.cli import GenerateCTypesupport
from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

folder = Path.cwd()
convert_action_to_idl(folder, "nav2_msgs", Path("action/NavigateToPose.action"), folder / "action")
needed = ("action_msgs", "builtin_interfaces", "geometry_msgs", "service_msgs", "std_msgs", "unique_identifier_msgs")
package = {"package_name": "nav2_msgs", "interface_files": ["action/NavigateToPose.idl"],
           "include_paths": [Path(sys.prefix) / "share" / name for name in needed]}
hashes = HashTypeDescription("").generate_type_hashes(**package, output_path=folder)
GenerateC("").generate(**package, output_path=Path("../c/nav2_msgs"), type_description_files=hashes)
for name, generate in (("fast", GenerateFastRTPSCTypesupport), ("introspection", GenerateIntrospectionCTypesupport),
                       ("support", GenerateCTypesupport), ("py", GeneratePython)):
    generate("").generate(**package, output_path=Path("..") / name / "nav2_msgs")
PYTHON

cd "$BUILD"
INCLUDE=$("$VENV/bin/python" -c 'import sysconfig, numpy; print("-I" + sysconfig.get_paths()["include"], "-I" + numpy.get_include())')
for folder in "$VENV"/include "$VENV"/include/* "$BUILD"/*; do INCLUDE+=" -I$folder"; done
LIBRARIES=""
for package in action_msgs builtin_interfaces geometry_msgs service_msgs unique_identifier_msgs; do
    for part in generator_c generator_py typesupport_c typesupport_fastrtps_c typesupport_introspection_c; do
        [ -f "$VENV/lib/lib${package}__rosidl_$part.so" ] && LIBRARIES+=" -l${package}__rosidl_$part"
    done
done
compile() {
    case $1 in *.cpp) set -- g++ -std=c++17 "$1" ;; *) set -- gcc -std=gnu11 "$1" ;; esac
    "$1" "$2" -O0 -fPIC -w $INCLUDE -c "$3" -o "$3.o"
}
export -f compile
export INCLUDE
find . -name '*.c' ! -name '*.ep.rosidl_typesupport_[fi]*' -o -name '*.cpp' | xargs -P "$(nproc)" -I{} bash -c 'compile {}'
# One library under the names by which it is looked for: as an extension of Python, and as each kind of type support.
g++ -shared -o library $(find . -name '*.o') -L"$VENV/lib" -Wl,-rpath,"$VENV/lib" $LIBRARIES -lrosidl_typesupport_c \
    -lrosidl_typesupport_fastrtps_c -lrosidl_typesupport_fastrtps_cpp -lrosidl_typesupport_introspection_c \
    -lrosidl_dynamic_typesupport -lrosidl_runtime_c -lrcutils -lrmw -lfastcdr
rm -rf "$SITE/nav2_msgs"
mkdir -p "$SITE/nav2_msgs/action"
cp py/nav2_msgs/action/*.py "$SITE/nav2_msgs/action/"
touch "$SITE/nav2_msgs/__init__.py"
cp library "$VENV/lib/libnav2_msgs__rosidl_typesupport_fastrtps_c.so"
ln -sf libnav2_msgs__rosidl_typesupport_fastrtps_c.so "$VENV/lib/libnav2_msgs__rosidl_typesupport_introspection_c.so"
ln -sf "$VENV/lib/libnav2_msgs__rosidl_typesupport_fastrtps_c.so" "$SITE/nav2_msgs/nav2_msgs_s__rosidl_typesupport_c.so"
"$VENV/bin/python" -c 'from nav2_msgs.action import NavigateToPose; NavigateToPose.__class__.__import_type_support__()'
