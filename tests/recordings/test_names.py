"""Columns of foreign logs recognised by their names, as phones, boards, autopilots and spreadsheets write them."""

from __future__ import annotations

import pyarrow as pa
import pytest

from recordings.names import guessed_maps
from recordings.units import parse_maps
from scenarios.errors import InputError

X, Y, Z = "mag_x_nT", "mag_y_nT", "mag_z_nT"
MAG = {
    "mx,my,mz": "mx,my,mz,-",
    "t,bx,by,bz": "bx,by,bz,-",
    "Hx,Hy,Hz,Zeit": "Hx,Hy,Hz,-",
    "t;x;y;z": "x,y,z,-",
    "time,magX,magY,magZ": "magX,magY,magZ,-",
    "timestamp,mag_x,mag_y,mag_z,gyro_x,gyro_y,gyro_z": "mag_x,mag_y,mag_z,-",
    "Time (s);Magnetic field x (µT);Magnetic field y (µT);Magnetic field z (µT)": "Magnetic field x (µT),"
    "Magnetic field y (µT),Magnetic field z (µT),uT",
    "t,x_uT,y_uT,z_uT": "x_uT,y_uT,z_uT,uT",
    "millis;X (in microteslas);Y (in microteslas);Z (in microteslas)": "X (in microteslas),Y (in microteslas),Z (in "
    "microteslas),uT",
    "TimeUS,MagX [mG],MagY [mG],MagZ [mG],OfsX,OfsY,OfsZ": "MagX [mG],MagY [mG],MagZ [mG],mG",
    "t_ms,compass_x,compass_y,compass_z": "compass_x,compass_y,compass_z,-",
    "magnetometer.x,magnetometer.y,magnetometer.z": "magnetometer.x,magnetometer.y,magnetometer.z,-",
    "field.header.stamp,field.magnetic_field.x,field.magnetic_field.y,field.magnetic_field.z": "field.magnetic_field.x,"
    "field.magnetic_field.y,field.magnetic_field.z,-",
    "time,seconds_elapsed,z,y,x": "x,y,z,-",
    "UncalMagXMicroT,UncalMagYMicroT,UncalMagZMicroT,BiasXMicroT,BiasYMicroT,BiasZMicroT": "UncalMagXMicroT,"
    "UncalMagYMicroT,UncalMagZMicroT,uT",
    "Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,Mag_X,Mag_Y,Mag_Z": "Mag_X,Mag_Y,Mag_Z,-",
    "IMU_ATTI(0):magX,IMU_ATTI(0):magY,IMU_ATTI(0):magZ": "IMU_ATTI(0):magX,IMU_ATTI(0):magY,IMU_ATTI(0):magZ,-",
    "time_boot_ms,xacc,yacc,zacc,xgyro,ygyro,zgyro,xmag,ymag,zmag": "xmag,ymag,zmag,-",
    "column_1,column_2,column_3": "column_1,column_2,column_3,-",
    "column_1,column_2,column_3,column_4": "column_2,column_3,column_4,-",
    "mag_raw_x,mag_raw_y,mag_raw_z,mag_cal_x,mag_cal_y,mag_cal_z": "mag_raw_x,mag_raw_y,mag_raw_z,-",
    "t,B_x_nT,B_y_nT,B_z_nT": "B_x_nT,B_y_nT,B_z_nT,nT",
    "t,Mag X (mGauss),Mag Y (mGauss),Mag Z (mGauss)": "Mag X (mGauss),Mag Y (mGauss),Mag Z (mGauss),mG",
    "t,Bx [T],By [T],Bz [T]": "Bx [T],By [T],Bz [T],T",
    "t,Mx (G),My (G),Mz (G)": "Mx (G),My (G),Mz (G),G",
    "time,raw_x,raw_y,raw_z": "raw_x,raw_y,raw_z,-",
    "t,magnetometer_x_counts,magnetometer_y_counts,magnetometer_z_counts": "magnetometer_x_counts,"
    "magnetometer_y_counts,magnetometer_z_counts,count",
    "loggingTime(txt),locationHeadingX(µT),locationHeadingY(µT),locationHeadingZ(µT)": "-",
    "loopIteration,time (us),axisI[0],axisI[1],axisI[2],magADC[0],magADC[1],magADC[2],debug[0]": "magADC[0],"
    "magADC[1],magADC[2],count",
    "time,ax,ay,az": "-",
    "heading,speed,depth": "-",
}
OTHERS = {
    "t_us,ax,ay,az,gx,gy,gz,mx,my,mz,qw,qx,qy,qz,temp": "time_s=t_us/us accel_x_m_s2=ax gyro_x_rad_s=gx att_qw=qw "
    "att_qz=qz temperature_degC=temp",
    "TIME_S,Acc_X,Acc_Y,Acc_Z,Mag_X,Mag_Y,Mag_Z,Quat_q0,Quat_q1,Quat_q2,Quat_q3": "accel_y_m_s2=Acc_Y att_qw=Quat_q0",
    "t,accel_x_g,accel_y_g,accel_z_g,gyro_x_dps,gyro_y_dps,gyro_z_dps,mx,my,mz": "accel_x_m_s2=accel_x_g/g "
    "gyro_z_rad_s=gyro_z_dps/deg/s",
    "millis,mx,my,mz,Temperature (°C)": "time_s=millis/ms temperature_degC=Temperature (°C)/degC",
    "time_boot_ms,xmag,ymag,zmag": "time_s=time_boot_ms/ms",
    "time (us),gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],magADC[0]": "time_s="
    "time (us)/us gyro_y_rad_s=gyroADC[1] accel_z_m_s2=accSmooth[2]",
    "seconds_elapsed,time,z,y,x": "time_s=time",
    "Time (ms),mx,my,mz": "time_s=Time (ms)/ms",
}


def table_of(header: str) -> pa.Table:
    names = header.split(";") if ";" in header else header.split(",")
    return pa.table({name: [0.0, 1.0, 2.0, 3.0] for name in names})


@pytest.mark.parametrize(("header", "expected"), MAG.items(), ids=MAG)
def test_the_magnetometer_is_found(header: str, expected: str) -> None:
    found = {one.target: one for one in guessed_maps(table_of(header), ())}
    if expected == "-":
        assert X not in found
        return
    assert [*(found[name].source for name in (X, Y, Z)), found[X].unit or "-"] == expected.split(",")


@pytest.mark.parametrize(("header", "expected"), OTHERS.items(), ids=OTHERS)
def test_time_and_the_other_sensors_are_found(header: str, expected: str) -> None:
    found = guessed_maps(table_of(header), ())
    said = " ".join(f"{one.target}={one.source}" + (f"/{one.unit}" if one.unit else "") for one in found)
    for part in expected.split(" "):
        assert part in said


def test_a_row_of_units_says_more_than_the_name() -> None:
    fields = [pa.field("t", pa.float64(), metadata={"unit": "ms"})]
    fields += [pa.field(name, pa.float64(), metadata={"unit": "µT"}) for name in ("mx", "my", "mz")]
    found = guessed_maps(pa.table([[0.0, 1.0]] * 4, schema=pa.schema(fields)), ())
    assert [one.unit for one in found] == ["ms", "uT", "uT", "uT"]


def test_of_two_magnetometers_one_has_to_be_chosen() -> None:
    with pytest.raises(InputError, match="--mag mag1_x,mag1_y,mag1_z"):
        guessed_maps(table_of("mag1_x,mag1_y,mag1_z,mag2_x,mag2_y,mag2_z"), ())


def test_names_of_a_recording_and_maps_come_first() -> None:
    assert guessed_maps(table_of(f"time_s,{X},{Y},{Z},gx,gy,gz,bx,by,bz"), ()) == ()
    maps = parse_maps([f"{X}=by", f"{Y}=bx", f"{Z}=bz"])
    assert [one.target for one in guessed_maps(table_of("t,bx,by,bz"), maps)] == ["time_s"]
