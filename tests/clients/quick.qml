// A scene for `./run clients`: a gradient, text, an animation and a canvas. GraphicsInfo.api is 5 on Vulkan.
import QtQuick
import QtQuick.Window

Window {
    width: 400; height: 300; visible: true; color: "#203040"
    Rectangle {
        x: 30; y: 30; width: 150; height: 100; radius: 20
        gradient: Gradient {
            GradientStop { position: 0; color: "orange" }
            GradientStop { position: 1; color: "purple" }
        }
        NumberAnimation on rotation { from: 0; to: 360; duration: 4000; loops: Animation.Infinite }
    }
    Timer { interval: 5500; running: true; onTriggered: Qt.quit() }
    Text { x: 200; y: 40; text: "Qt Quick\napi " + GraphicsInfo.api; color: "white"; font.pixelSize: 28 }
    Canvas {
        x: 20; y: 170; width: 340; height: 110
        onPaint: {
            const c = getContext("2d")
            c.strokeStyle = "#80ff80"
            c.lineWidth = 4
            c.beginPath()
            for (let i = 0; i < 340; i++) c.lineTo(i, 55 + 40 * Math.sin(i / 20))
            c.stroke()
        }
    }
}
