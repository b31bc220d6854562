"""The messages of a navigation, for Cyclone DDS, with the names of their types in ROS 2."""
from cyclone_ros import Time, struct
from cyclonedds.idl import types

real, short = types.float64, types.float32
geometry, nav, std = "geometry_msgs::msg::dds_::", "nav_msgs::msg::dds_::", "std_msgs::msg::dds_::"
Header = struct(f"{std}Header_", stamp=Time, frame_id=str)
Point = struct(f"{geometry}Point_", x=real, y=real, z=real)
Quaternion = struct(f"{geometry}Quaternion_", x=real, y=real, z=real, w=real)
Pose = struct(f"{geometry}Pose_", position=Point, orientation=Quaternion)
PoseStamped = struct(f"{geometry}PoseStamped_", header=Header, pose=Pose)
Covariance = types.array[real, 36]
PoseWithCovariance = struct(f"{geometry}PoseWithCovariance_", pose=Pose, covariance=Covariance)
PoseWithCovarianceStamped = struct(f"{geometry}PoseWithCovarianceStamped_", header=Header, pose=PoseWithCovariance)
Vector3 = struct(f"{geometry}Vector3_", x=real, y=real, z=real)
Twist = struct(f"{geometry}Twist_", linear=Vector3, angular=Vector3)
MapMetaData = struct(f"{nav}MapMetaData_", map_load_time=Time, resolution=short, width=types.uint32,
                     height=types.uint32, origin=Pose)
OccupancyGrid = struct(f"{nav}OccupancyGrid_", header=Header, info=MapMetaData, data=types.sequence[types.int8])
LaserScan = struct("sensor_msgs::msg::dds_::LaserScan_", header=Header, angle_min=short, angle_max=short,
                   angle_increment=short, time_increment=short, scan_time=short, range_min=short, range_max=short,
                   ranges=types.sequence[short], intensities=types.sequence[short])
Duration = struct("builtin_interfaces::msg::dds_::Duration_", sec=types.int32, nanosec=types.uint32)

# The action: its name, its type, and the fields of its goal, its result and its feedback.
NAVIGATE_TO_POSE = [
    "/navigate_to_pose", "nav2_msgs::action::dds_::NavigateToPose",
    {"pose": PoseStamped, "behavior_tree": str}, {"error_code": types.uint16, "error_msg": str},
    {"current_pose": PoseStamped, "navigation_time": Duration, "estimated_time_remaining": Duration,
     "number_of_recoveries": types.int16, "distance_remaining": short},
]


def duration(seconds):
    return Duration(int(seconds), int(seconds % 1 * 1e9))
